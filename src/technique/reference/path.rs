//! Which radiance does one path find?

use super::{Bounces, Estimate, Setting};
use glam::{DVec3, Vec2, Vec3};
use twinlight_kernels::geometry::bvh::{Hit, NO_TRIANGLE, Ray, any_hit, nearest_hit};
use twinlight_kernels::math::{self, FRAC_1_PI, dot};
use twinlight_kernels::passes::elements::Surface;
use twinlight_kernels::passes::gather::{emission_at, environment_radiance};
use twinlight_kernels::passes::light::{incident_light, shadow_ray};
use twinlight_kernels::passes::material::{AlphaTest, Reflectance, phong_lobe, reflectance};
use twinlight_kernels::passes::surface::{camera_direction, ray_origin, surface_at};
use twinlight_kernels::sampling::hash::{combine, hash, unit_float};
use twinlight_kernels::sampling::hemisphere::{cosine_hemisphere, to_world};

/// Paths longer than this end whatever the roulette says: at a survival of at most 0.95 none gets here in practice.
const LONGEST: u32 = 4096;
/// Reflections before Russian roulette begins.
const CERTAIN: u32 = 4;

/// The random numbers of one path.
struct Random {
    state: u32,
}

impl Random {
    fn next(&mut self) -> f32 {
        self.state = self.state.wrapping_add(0x9E37_79B9);
        unit_float(hash(self.state))
    }
}

fn double(v: Vec3) -> DVec3 {
    v.as_dvec3()
}

/// Traces path `sample` of a pixel.
pub(crate) fn trace(setting: &Setting<'_>, pixel: u32, sample: u32) -> Estimate {
    let mut random = Random { state: combine(combine(setting.settings.seed, pixel), sample) };
    let camera = &setting.camera;
    let (jitter_x, jitter_y) =
        if setting.settings.pixel_filter { (random.next(), random.next()) } else { (0.5, 0.5) };
    let x = (pixel % camera.width) as f32 + jitter_x;
    let y = (pixel / camera.width) as f32 + jitter_y;
    let mut direction = camera_direction(camera, x, y);
    let mut hit = nearest(setting, camera.eye.truncate(), direction);
    let mut estimate = Estimate { direct: double(source(setting, &hit, direction)), indirect: DVec3::ZERO };
    let mut throughput = DVec3::ONE;
    let last = match setting.settings.bounces {
        Bounces::Count(n) => n,
        Bounces::All => LONGEST,
    };
    let distant_sources = setting.has_environment || setting.settings.emissive;
    for depth in 0..=last {
        if hit.triangle == NO_TRIANGLE {
            break;
        }
        let scene = setting.scene;
        let surface = surface_at(&hit, direction, &scene.triangles, &scene.materials, &setting.texels);
        let uv = Vec2::new(surface.u, surface.v);
        let lobes = reflectance(&scene.materials[surface.material as usize], &setting.texels, uv);
        add(&mut estimate, depth, throughput * double(from_lights(setting, &surface, &lobes, -direction)));
        if depth == last && !distant_sources {
            break;
        }
        let Some((next, weight)) = scatter(&surface, &lobes, -direction, &mut random) else { break };
        throughput *= double(weight);
        if throughput.max_element() <= 0.0 {
            break;
        }
        if matches!(setting.settings.bounces, Bounces::All) && depth >= CERTAIN {
            let survival = throughput.max_element().min(0.95);
            if f64::from(random.next()) >= survival {
                break;
            }
            throughput /= survival;
        }
        let triangle = &scene.triangles[surface.triangle as usize];
        hit = nearest(setting, ray_origin(surface.position.truncate(), triangle, next), next);
        direction = next;
        add(&mut estimate, depth, throughput * double(source(setting, &hit, direction)));
    }
    estimate
}

/// Light that reaches the first surface from a source is direct, all other indirect.
fn add(estimate: &mut Estimate, depth: u32, radiance: DVec3) {
    if depth == 0 {
        estimate.direct += radiance;
    } else {
        estimate.indirect += radiance;
    }
}

fn alpha<'a>(setting: &'a Setting<'_>) -> AlphaTest<'a> {
    AlphaTest {
        triangles: &setting.scene.triangles,
        materials: &setting.scene.materials,
        texels: &setting.texels,
    }
}

pub(super) fn nearest(setting: &Setting<'_>, origin: Vec3, direction: Vec3) -> Hit {
    let ray = Ray { origin, direction, t_min: 0.0, t_max: 1.0e30 };
    nearest_hit(&setting.tree.nodes, &setting.tree.blocks, &ray, &alpha(setting))
}

/// What a ray sees emitted where it ends: by the environment or by an emissive surface.
fn source(setting: &Setting<'_>, hit: &Hit, direction: Vec3) -> Vec3 {
    if hit.triangle == NO_TRIANGLE {
        return environment_radiance(&setting.environment, &setting.texels, direction);
    }
    if !setting.settings.emissive {
        return Vec3::ZERO;
    }
    let scene = setting.scene;
    emission_at(hit, direction, &scene.triangles, &scene.materials, &setting.texels)
}

/// The radiance toward the viewer from all lights without extent.
pub(super) fn from_lights(
    setting: &Setting<'_>,
    surface: &Surface,
    lobes: &Reflectance,
    to_viewer: Vec3,
) -> Vec3 {
    let position = surface.position.truncate();
    let normal = surface.normal.truncate();
    let triangle = &setting.scene.triangles[surface.triangle as usize];
    let mut radiance = Vec3::ZERO;
    for light in &setting.scene.lights {
        let incident = incident_light(light, position);
        let cosine = dot(incident.direction, normal);
        if cosine <= 0.0 || incident.irradiance.max_element() <= 0.0 {
            continue;
        }
        let ray = shadow_ray(light, ray_origin(position, triangle, incident.direction), incident.direction);
        if any_hit(&setting.tree.nodes, &setting.tree.blocks, &ray, &alpha(setting)) {
            continue;
        }
        let mut reflected = lobes.diffuse * FRAC_1_PI;
        if lobes.specular.max_element() > 0.0 {
            reflected += lobes.specular * phong_lobe(normal, to_viewer, incident.direction, lobes.exponent);
        }
        radiance += reflected * incident.irradiance * cosine;
    }
    radiance
}

/// A scattered direction and the path's weight along it: reflectance times cosine over density.
///
/// Chooses the diffuse or the specular lobe by their share; the density is that of the mixture.
fn scatter(
    surface: &Surface,
    lobes: &Reflectance,
    to_viewer: Vec3,
    random: &mut Random,
) -> Option<(Vec3, Vec3)> {
    let normal = surface.normal.truncate();
    let diffuse = lobes.diffuse.element_sum();
    let specular = lobes.specular.element_sum();
    if diffuse + specular <= 0.0 {
        return None;
    }
    let specular_share = specular / (diffuse + specular);
    let (choice, u) = (random.next(), Vec2::new(random.next(), random.next()));
    let mirror = math::normalize_or(normal * (2.0 * dot(normal, to_viewer)) - to_viewer, normal);
    let direction = if choice < specular_share {
        // cosⁿ about the mirror direction: density (n + 1)/2π cosⁿ
        let cosine = (1.0 - u.x).powf(1.0 / (lobes.exponent + 1.0));
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (s, c) = math::sin_cos_turn(u.y);
        to_world(Vec3::new(sine * c, sine * s, cosine), mirror)
    } else {
        to_world(cosine_hemisphere(u), normal)
    };
    let direction = math::normalize_or(direction, normal);
    let cosine = dot(direction, normal);
    if cosine <= 0.0 {
        return None;
    }
    if specular <= 0.0 {
        // The cosine and π cancel exactly.
        return Some((direction, lobes.diffuse));
    }
    let lobe = phong_lobe(normal, to_viewer, direction, lobes.exponent);
    let diffuse_density = cosine * FRAC_1_PI;
    let specular_density = lobe * (lobes.exponent + 1.0) / (lobes.exponent + 2.0);
    let density = (1.0 - specular_share) * diffuse_density + specular_share * specular_density;
    if density <= 0.0 {
        return None;
    }
    let reflected = lobes.diffuse * FRAC_1_PI + lobes.specular * lobe;
    Some((direction, reflected * (cosine / density)))
}
