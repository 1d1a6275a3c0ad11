"""How does Mitsuba render a scene for equal_error.py, and how long does it take?"""

import subprocess
import sys
import time

import numpy as np

from mitsuba_reference import Fail, build_scene, integrator, load_glb, mitsuba, view_of

PROBE = """import mitsuba as mi
mi.set_variant('llvm_ad_rgb')
scene = mi.cornell_box(); scene['sensor']['film'].update(width=8, height=8)
print(float(mi.render(mi.load_dict(scene), spp=1).array[0]))"""


def check_mitsuba():
    """In a process of its own, as an LLVM that is too old for Dr.Jit ends the process."""
    run = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True)
    if "No module named" in run.stderr:
        raise Fail("mitsuba is not installed; see docs/peers/README.md")
    if run.returncode:
        raise Fail("Mitsuba's llvm_ad_rgb does not work here: install a newer LLVM library (such as libllvm19) and "
                   "point DRJIT_LIBLLVM_PATH at it")


def second_bounce(mi, dr, masked):
    """An integrator of the indirect light of one bounce alone: three rays a path instead of the four of `path`, and
    none of the noise of direct light. For lights without extent only: what the bounce hits is taken to emit nothing."""

    class SecondBounce(mi.SamplingIntegrator):  # dr.syntax compiles anew: its functions see no variables of this one
        def hole(self, si, active):
            return active & si.is_valid() & (si.bsdf().eval_null_transmission(si, active).x > 0.5)

        @dr.syntax
        def nearest(self, scene, ray, active):
            si = scene.ray_intersect(ray, active)
            if self.masked:
                hole = self.hole(si, active)
                while hole:
                    si = scene.ray_intersect(si.spawn_ray(ray.d), hole)
                    hole = self.hole(si, hole)
            return si

        @dr.syntax
        def blocked(self, scene, si, point, active):
            ray = si.spawn_ray_to(point)
            if not self.masked:
                hit = scene.ray_test(ray, active)
            else:
                hit, going = active & False, active & True
                while going:
                    between = scene.ray_intersect(ray, going)
                    hole = self.hole(between, going)
                    hit |= going & between.is_valid() & ~hole
                    ray = between.spawn_ray_to(point)
                    going = hole
            return hit

        def sample(self, scene, sampler, ray, medium=None, active=True):
            context = mi.BSDFContext()
            first = self.nearest(scene, ray, mi.Bool(active))
            active = first.is_valid() & active
            way, weight = first.bsdf().sample(context, first, sampler.next_1d(active), sampler.next_2d(active), active)
            active &= way.pdf > 0
            second = self.nearest(scene, first.spawn_ray(first.to_world(way.wo)), active)
            active &= second.is_valid()
            light, incident = scene.sample_emitter_direction(second, sampler.next_2d(active), False, active)
            seen = weight * incident * second.bsdf().eval(context, second, second.to_local(light.d), active)
            active &= dr.any(seen > 0)  # no shadow ray where no light would come
            active &= ~self.blocked(scene, second, light.p, active)
            return dr.select(active, seen, 0), active, []

    made = SecondBounce(mi.Properties())
    made.masked = masked
    return made


class Peer:
    """Mitsuba on one scene: references, and renderings with their time."""

    def __init__(self, scene, surroundings=None):
        """Of the bounce alone; under surroundings, which are an emitter, of all light."""
        import drjit as dr
        self.mi, self.dr, self.sensors = mitsuba("llvm_ad_rgb"), dr, {}
        self.mi.set_log_level(self.mi.LogLevel.Error)  # no word on every number of samples that gets rounded
        self.view = view_of({"up": [0, 1, 0], **scene})
        self.scene, self.masked = build_scene(load_glb(scene["file"]), self.view, (512, 512), surroundings=surroundings)
        self.stock = "volpath" if self.masked else "path"
        direct, path = (integrator(self.mi, bounces, self.masked) for bounces in (0, 1))
        self.methods = {  # integrator, what to subtract, sampler; the last one makes the references
            self.stock: (path, direct, "independent"),
            "bounce": (second_bounce(self.mi, dr, self.masked), None, "multijitter"),
        } if surroundings is None else {
            self.stock: (path, None, "independent"),
            "multijitter": (path, None, "multijitter"),
        }

    def sensor(self, side, sampler):
        if (side, sampler) not in self.sensors:
            v, T = self.view, self.mi.ScalarTransform4f
            self.sensors[side, sampler] = self.mi.load_dict({
                "type": "perspective", "fov": float(v["fov"]), "fov_axis": "y", "near_clip": 1e-3, "far_clip": 1e5,
                "to_world": T().look_at(origin=v["eye"], target=v["target"], up=v["up"]),
                "film": {"type": "hdrfilm", "width": side, "height": side, "pixel_format": "rgb",
                         "component_format": "float32", "rfilter": {"type": "box"}},
                "sampler": {"type": sampler}})
        return self.sensors[side, sampler]

    def render(self, name, side, spp, seed):
        """The light, the seconds of the kernels (not of recording and compiling them), and the samples of a
        pixel, which multijitter may round up. From the stock integrator's picture, that of the same seed without the
        bounce is taken, untimed: its camera rays and light samples are the same, so direct light cancels exactly."""
        whole, direct, sampler = self.methods[name]
        sensor = self.sensor(side, sampler)
        image = self.mi.render(self.scene, sensor=sensor, integrator=whole, spp=spp, seed=seed)
        start = time.perf_counter()
        self.dr.eval(image)
        self.dr.sync_thread()
        seconds = time.perf_counter() - start
        picture = np.array(image, dtype=np.float64)[..., :3]
        if direct is not None:
            less = self.mi.render(self.scene, sensor=sensor, integrator=direct, spp=spp, seed=seed)
            picture = picture - np.array(less, dtype=np.float64)[..., :3]
        return picture, seconds, sensor.sampler().sample_count()
