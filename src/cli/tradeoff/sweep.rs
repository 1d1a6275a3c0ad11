//! Which settings are tried?
//!
//! Every point is a `render` command line: what is measured is what that command does. Values stand for themselves, but for
//! `{1/4}`, which is a quarter of the picture's sides.

/// What a scene must have for a setting to do anything.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Needs {
    Nothing,
    /// Glossy surfaces.
    Gloss,
    /// Meshes to which spheres can be fitted: a scene that asks for it.
    Fitted,
    /// A GPU.
    Gpu,
}

/// A knob with the values that are tried beside its default, the others at theirs.
pub(super) struct Knob {
    /// The option without its dashes.
    pub name: &'static str,
    pub values: &'static [&'static str],
    pub needs: Needs,
}

/// A technique with what is tried of it.
pub(super) struct Sweep {
    pub technique: &'static str,
    /// Several knobs at once, from quick to good: between them the front is looked for.
    pub ladder: &'static [&'static str],
    pub knobs: &'static [Knob],
}

const fn knob(name: &'static str, values: &'static [&'static str]) -> Knob {
    Knob { name, values, needs: Needs::Nothing }
}

const fn glossy(name: &'static str, values: &'static [&'static str]) -> Knob {
    Knob { name, values, needs: Needs::Gloss }
}

const UPSAMPLING: Knob = knob("upsampling", &["bilinear", "nearest"]);
const ARITHMETIC: Knob = Knob { name: "arithmetic", values: &["strict"], needs: Needs::Gpu };

const VISIBILITY_FILTER: Sweep = Sweep {
    technique: "visibility-filter",
    ladder: &[
        "--rays 4 --proxies 10000 --illumination {1/8} --marching {1/16} --light-map 256",
        "--rays 4 --proxies 10000 --illumination {1/4} --marching {1/8}",
        "--rays 8 --proxies 20000 --illumination {1/4}",
        "--rays 16 --illumination {1/4}",
        "--rays 256 --illumination {1}",
        "--rays 256 --proxies 240000 --illumination {1} --marching {1/2} --grid 16",
    ],
    knobs: &[
        ARITHMETIC,
        UPSAMPLING,
        knob("proxies", &["5000", "15000", "30000", "120000", "240000", "480000"]),
        knob("overlap", &["1 --meet proxies", "2 --meet proxies", "8 --meet proxies"]),
        knob("grid", &["6", "12", "16", "32", "64"]),
        knob("rays", &["4", "16", "32", "128", "256"]),
        knob("marching", &["{1/16}", "{1/8}", "{1/2}"]),
        knob("illumination", &["{1/8}", "{1/4}", "{1}"]),
        knob("filter", &["1", "3", "5", "9"]),
        knob("filter-depth", &["0.002", "0.1"]),
        knob("filter-normal", &["0", "0.5", "0.98"]),
        knob("near-range", &["0", "1e9"]),
        knob("gather", &["sum"]),
        knob("trust", &["0", "1", "4"]),
        knob("clamp", &["radius", "none"]),
        knob("light-map", &["128", "256", "1024"]),
        knob("meet", &["proxies"]),
        knob("anchor", &["world"]),
        knob("depth-deviation", &["0.002", "0.05"]),
        knob("normal-deviation", &["0.02", "0.5"]),
        glossy("lobe-rays", &["8", "64", "256"]),
        glossy("specular-deviation", &["0.03", "0.1", "0.3"]),
        glossy("specular-exponent", &["8 --specular-deviation 0.1", "64 --specular-deviation 0.1"]),
        glossy("proxy-gloss", &["false"]),
    ],
};

const VOXEL_CONES: Sweep = Sweep {
    technique: "voxel-cones",
    ladder: &[
        "--resolution 32 --cones 6 --illumination {1/8} --photons 256",
        "--resolution 64 --cones 6 --illumination {1/4} --photons 512",
        "--cones 6 --illumination {1/4}",
        "--cones 6",
        "--resolution 256 --cones 32",
        "--resolution 256 --cones 64 --illumination {1} --interleave false",
    ],
    knobs: &[
        ARITHMETIC,
        UPSAMPLING,
        knob("resolution", &["32", "64", "256", "512"]),
        knob("cones", &["1", "3", "9", "32", "64"]),
        knob("half-angle", &["15", "30", "45", "60"]),
        knob("step", &["0.25", "0.5", "2"]),
        knob("voxel-width", &["0.25", "1", "2"]),
        knob("start", &["0.5", "2", "4"]),
        knob("clearance", &["0", "1", "4"]),
        knob("cutoff", &["0.1", "0.001"]),
        knob("interleave", &["false"]),
        knob("anisotropic", &["false"]),
        knob("voxelisation", &["thin"]),
        knob("radiance-storage", &["unorm8", "fixed", "half", "float"]),
        knob("photons", &["128", "256", "512", "2048"]),
        knob("illumination", &["{1/8}", "{1/4}", "{1}"]),
        glossy("specular-half-angle", &["5", "10", "20", "45"]),
    ],
};

const LAYERED_RSM: Sweep = Sweep {
    technique: "layered-rsm",
    ladder: &[
        "--resolution 64 --cones 6 --illumination {1/8} --rsm 128 --depth-layers 1 --normal-layers 1",
        "--resolution 64 --cones 6 --illumination {1/4} --rsm 256",
        "--cones 6 --illumination {1/4}",
        "--cones 6",
        "--resolution 512 --cones 32 --rsm 1024",
    ],
    knobs: &[
        ARITHMETIC,
        UPSAMPLING,
        knob("resolution", &["32", "64", "256", "512"]),
        knob("rsm", &["64", "128", "256", "1024", "2048"]),
        knob("depth-layers", &["1", "4", "8"]),
        knob("normal-layers", &["1", "4", "8"]),
        knob("layer-overlap", &["0.1", "0.3"]),
        knob("least-level", &["1", "2", "4"]),
        knob("most-level", &["0", "1", "2"]),
        knob("moments", &["float", "unorm16"]),
        knob("deviation", &["0.001", "0.01", "0.1"]),
        knob("window", &["0.75", "1", "2"]),
        knob("footprint", &["0.5", "2"]),
        knob("weights", &["opacity"]),
        knob("opacity", &["mean"]),
        knob("cones", &["1", "3", "9", "32", "64"]),
        knob("half-angle", &["15", "30", "45", "60"]),
        knob("step", &["0.25", "0.5", "2"]),
        knob("voxel-width", &["0.25", "1", "2"]),
        knob("start", &["0.5", "2", "4"]),
        knob("clearance", &["0", "1", "4"]),
        knob("cutoff", &["0.1", "0.001"]),
        knob("interleave", &["false"]),
        knob("illumination", &["{1/8}", "{1/4}", "{1}"]),
        glossy("specular-half-angle", &["5", "10", "20", "45"]),
    ],
};

const SOFT_GI: Sweep = Sweep {
    technique: "soft-gi",
    ladder: &[
        "--order 2 --receiver-scale 8 --shadow-reach 5 --light-reach 5 --operator point",
        "--order 3 --receiver-scale 8",
        "--order 3 --receiver-scale 4",
        "--order 5 --receiver-scale 1 --operator exact --light-reach 30 --shadow-reach 30",
    ],
    knobs: &[
        ARITHMETIC,
        UPSAMPLING,
        knob("order", &["2", "3", "5"]),
        knob(
            "exponential",
            &["optimal-linear", "series", "series --terms 3", "taylor", "taylor --tau 1", "product"],
        ),
        knob("tau", &["1", "0.25", "0.125", "0.0625"]),
        knob("operator", &["point", "averaged-fit", "exact"]),
        knob("shadow-reach", &["5", "10", "15", "30"]),
        knob("light-reach", &["5", "15", "30"]),
        knob("receiver-scale", &["1", "4", "8"]),
        knob("log-entries", &["16", "32", "128", "256"]),
        knob("self-shadow-fade", &["0.1", "0.25", "1"]),
        Knob {
            name: "fit-spheres",
            values: &["8", "16", "32", "64", "128", "256", "512"],
            needs: Needs::Fitted,
        },
    ],
};

/// A stage of a technique and settings under which it is as good as exact.
pub(super) struct Stage {
    pub technique: &'static str,
    pub name: &'static str,
    /// What stands in its place.
    pub exact: &'static str,
    pub settings: &'static str,
    /// Minutes a frame where surfaces are glossy: left out there.
    pub diffuse: bool,
}

const fn stage(
    technique: &'static str,
    name: &'static str,
    exact: &'static str,
    settings: &'static str,
) -> Stage {
    Stage { technique, name, exact, settings, diffuse: false }
}

const fn diffuse_stage(
    technique: &'static str,
    name: &'static str,
    exact: &'static str,
    settings: &'static str,
) -> Stage {
    Stage { diffuse: true, ..stage(technique, name, exact, settings) }
}

/// The stages that settings make exact, or as exact as they can be.
pub(super) const STAGES: [Stage; 25] = [
    stage("visibility-filter", "upsampling", "light gathered at every pixel", "--illumination {1}"),
    stage("visibility-filter", "coarse pixels", "rays from every pixel", "--marching {1}"),
    stage("visibility-filter", "number of rays", "1024 rays", "--rays 1024"),
    stage("visibility-filter", "sharing between pixels", "each alone, 1024 rays", "--filter 1 --rays 1024"),
    stage(
        "visibility-filter",
        "visibility",
        "rays alone, 256 from every pixel",
        "--rays 256 --filter 1 --trust 0 --marching {1} --illumination {1}",
    ),
    diffuse_stage(
        "visibility-filter",
        "size of voxels",
        "64 along a side, a million proxies",
        "--grid 64 --proxies 1000000",
    ),
    diffuse_stage(
        "visibility-filter",
        "visibility and size of voxels",
        "both",
        "--rays 256 --filter 1 --trust 0 --marching {1} --illumination {1} --grid 64 --proxies 1000000",
    ),
    stage("visibility-filter", "far voxels", "proxy by proxy", "--near-range 1e9"),
    stage("visibility-filter", "number of proxies", "four times as many", "--proxies 240000"),
    stage("voxel-cones", "upsampling", "light gathered at every pixel", "--illumination {1}"),
    stage("voxel-cones", "number of cones", "64 cones, alike in all pixels", "--cones 64 --interleave false"),
    stage("voxel-cones", "size of voxels", "512 along a side", "--resolution 512"),
    stage("voxel-cones", "light on voxels", "maps of 4096² photons", "--photons 4096"),
    stage("layered-rsm", "upsampling", "light gathered at every pixel", "--illumination {1}"),
    stage("layered-rsm", "number of cones", "64 cones, alike in all pixels", "--cones 64 --interleave false"),
    stage("layered-rsm", "size of voxels", "512 along a side", "--resolution 512"),
    stage(
        "layered-rsm",
        "moments of depth",
        "floats without least deviation",
        "--moments float --deviation 0",
    ),
    stage("layered-rsm", "number of layers", "8 × 8", "--depth-layers 8 --normal-layers 8"),
    stage("layered-rsm", "size of maps", "2048²", "--rsm 2048"),
    stage("soft-gi", "receivers", "every pixel", "--receiver-scale 1"),
    stage("soft-gi", "order of harmonics", "5", "--order 5"),
    stage("soft-gi", "mean light of a proxy", "as it is distributed", "--operator exact"),
    stage("soft-gi", "reach", "1000 radii", "--shadow-reach 1000 --light-reach 1000"),
    stage("soft-gi", "exponential", "τ = 1/16", "--tau 0.0625"),
    stage("soft-gi", "sum of logarithms", "product of visibilities", "--exponential product"),
];

impl Stage {
    pub(super) fn trial(&self, size: (u32, u32)) -> Trial {
        trial(self.technique, "stage", self.name, self.settings, size)
    }
}

/// All techniques that are swept.
pub(super) const SWEEPS: [&Sweep; 4] = [&VISIBILITY_FILTER, &VOXEL_CONES, &LAYERED_RSM, &SOFT_GI];

/// Paths per pixel of the baseline.
pub(super) const BASELINE: [&str; 8] = ["1", "2", "4", "8", "16", "32", "64", "128"];

/// A setting to try.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Trial {
    pub technique: &'static str,
    /// The knob that is not at its default; `several` for a step of the ladder, none for the defaults.
    pub knob: &'static str,
    pub value: String,
    /// Words beyond the technique's name.
    pub words: Vec<String>,
}

impl Trial {
    pub(crate) fn settings(&self) -> String {
        self.words.join(" ")
    }
}

/// `{1/4}` as the pixels that it stands for.
fn in_pixels(word: &str, (width, height): (u32, u32)) -> String {
    let Some(share) = word.strip_prefix('{').and_then(|w| w.strip_suffix('}')) else {
        return word.to_owned();
    };
    let part: u32 = share.strip_prefix("1/").and_then(|d| d.parse().ok()).unwrap_or(1);
    format!("{}x{}", width.div_ceil(part), height.div_ceil(part))
}

fn trial(technique: &'static str, knob: &'static str, value: &str, text: &str, size: (u32, u32)) -> Trial {
    let words = text.split_whitespace().map(|w| in_pixels(w, size)).collect();
    Trial { technique, knob, value: in_pixels(value, size), words }
}

impl Sweep {
    /// The defaults and the ladder.
    pub(super) fn steps(&self, size: (u32, u32)) -> Vec<Trial> {
        let mut all = vec![trial(self.technique, "", "", "", size)];
        let numbered = self.ladder.iter().enumerate();
        all.extend(numbered.map(|(i, text)| {
            let step = format!("step {} of {}", i + 1, self.ladder.len());
            trial(self.technique, "several", &step, text, size)
        }));
        all
    }

    /// One knob after the other, those first that only such a scene or machine has.
    pub(super) fn single(&self, size: (u32, u32), has: impl Fn(Needs) -> bool) -> Vec<Trial> {
        let mut knobs: Vec<_> = self.knobs.iter().filter(|k| has(k.needs)).collect();
        knobs.sort_by_key(|k| k.needs == Needs::Nothing);
        let values = knobs.into_iter().flat_map(|k| k.values.iter().map(move |value| (k.name, *value)));
        values.map(|(name, v)| trial(self.technique, name, v, &format!("--{name} {v}"), size)).collect()
    }
}

/// A technique's defaults and its steps from quick to good; `None` for a technique that has none.
pub(crate) fn steps_of(technique: &str, size: (u32, u32)) -> Option<Vec<Trial>> {
    Some(SWEEPS.iter().find(|s| s.technique == technique)?.steps(size))
}

/// The path tracer with this many paths.
pub(super) fn baseline(size: (u32, u32)) -> Vec<Trial> {
    BASELINE.iter().map(|n| trial("reference", "samples", n, &format!("--samples {n}"), size)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_become_pixels() {
        let t = trial("voxel-cones", "illumination", "{1/4}", "--illumination {1/4}", (513, 256));
        assert_eq!((t.settings().as_str(), t.value.as_str()), ("--illumination 129x64", "129x64"));
        assert_eq!(in_pixels("{1}", (7, 5)), "7x5");
    }

    #[test]
    fn no_setting_is_tried_twice() {
        for sweep in SWEEPS {
            let mut all: Vec<_> = sweep.steps((512, 512)).iter().map(Trial::settings).collect();
            all.extend(sweep.single((512, 512), |_| true).iter().map(Trial::settings));
            let count = all.len();
            all.sort();
            all.dedup();
            assert_eq!(all.len(), count, "{}", sweep.technique);
        }
    }

    #[test]
    fn every_setting_is_allowed_and_is_not_the_default() {
        let view = crate::scene::Scene::open("cornell-glossy").unwrap().view();
        let view = crate::technique::View::new(&view, 512, 512).unwrap();
        let technique = |t: &Trial| {
            let mut words = vec!["cornell-glossy".to_owned(), format!("--technique={}", t.technique)];
            words.extend(t.words.iter().cloned());
            let a = crate::cli::render::parse_line(&words).unwrap_or_else(|_| panic!("{}", t.settings()));
            let request = crate::cli::render::request_of(&a, &view);
            request.unwrap_or_else(|_| panic!("{} {}", t.technique, t.settings()))
        };
        for sweep in SWEEPS {
            let steps = sweep.steps((512, 512));
            let default = technique(&steps[0]);
            // Arithmetic is the device's, and spheres are the scene's.
            let elsewhere = |t: &&Trial| !matches!(t.knob, "arithmetic" | "fit-spheres");
            let single = sweep.single((512, 512), |_| true);
            for t in steps[1..].iter().chain(&single).filter(elsewhere) {
                assert!(technique(t) != default, "{} {}", t.technique, t.settings());
            }
            for stage in STAGES.iter().filter(|s| s.technique == sweep.technique) {
                assert!(technique(&stage.trial((512, 512))) != default, "{}", stage.settings);
            }
        }
    }
}
