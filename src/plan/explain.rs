//! What does a plan cost: passes, buffers, bytes, and what runs again after a change?

use super::{Effect, Plan};
use crate::backend::Allocation;
use crate::renderer::Counts;
use std::fmt::Write;
use twinlight_kernels::passes::PassTiming;

/// A kind of change between two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Change {
    /// Nothing at all.
    Nothing,
    /// The view.
    Camera,
    /// Lights, or the surroundings.
    Lights,
    /// Where triangles are.
    Meshes,
    /// What surfaces reflect or emit.
    Materials,
}

impl Change {
    /// Every kind.
    pub const ALL: [Self; 5] = [Self::Nothing, Self::Camera, Self::Lights, Self::Meshes, Self::Materials];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Camera => "camera",
            Self::Lights => "lights",
            Self::Meshes => "meshes",
            Self::Materials => "materials",
        }
    }
}

/// What follows from a plan for a scene.
#[derive(Clone, Debug, Default)]
pub struct Costs {
    /// The passes of a first picture, in order; their times are 0.
    pub passes: Vec<PassTiming>,
    /// The buffers made for it, those of the scene first.
    pub buffers: Vec<Allocation>,
    /// The passes of the next picture after each kind of change.
    pub again: Vec<(Change, Vec<PassTiming>)>,
    /// How much there is to do, such as the number of lit voxels.
    pub counts: Counts,
    /// The passes that were computed to know these sizes.
    pub computed: Vec<&'static str>,
}

impl Costs {
    /// Bytes of all buffers that are ever made for the first picture.
    pub fn bytes(&self) -> u64 {
        self.buffers.iter().map(|b| b.bytes).sum()
    }

    /// The passes' pipelines: each once, sorted by name.
    pub fn pipelines(&self) -> Vec<&'static str> {
        let mut names: Vec<_> = self.passes.iter().map(|p| p.pass).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}

/// The stages of passes in their order, each once.
pub fn stages(passes: &[PassTiming]) -> Vec<&'static str> {
    let mut list = Vec::new();
    for p in passes {
        if !list.contains(&p.stage) {
            list.push(p.stage);
        }
    }
    list
}

/// The name of a stage in tables.
fn shown(stage: &str) -> &str {
    if stage.is_empty() { "picture" } else { stage }
}

impl Plan {
    /// The effects with the reason for each, as text.
    pub fn text(&self) -> String {
        let mut text =
            format!("{}, {} x {} pixels\n", self.technique.name(), self.view.width, self.view.height);
        for d in &self.decisions {
            let called = if d.called { "yes" } else { "no" };
            let bound = d.bound.filter(|_| !d.called).map_or(String::new(), |b| format!("; {b}"));
            let _ = writeln!(text, "{:<16} {called:<4} {}{bound}", d.effect.name(), d.why);
        }
        text
    }

    /// The effects that are called for.
    pub fn effects(&self) -> Vec<Effect> {
        self.decisions.iter().filter(|d| d.called).map(|d| d.effect).collect()
    }
}

impl Costs {
    /// Passes, buffers and what runs again, as text.
    pub fn text(&self) -> String {
        let mut text =
            format!("\n{:<16} {:<24} {:>5} {:>12} {:>14}\n", "stage", "pass", "runs", "items", "bytes bound");
        for stage in stages(&self.passes) {
            let mut seen: Vec<(&str, u32, u64, u64)> = Vec::new();
            for p in self.passes.iter().filter(|p| p.stage == stage) {
                match seen.iter_mut().find(|s| s.0 == p.pass) {
                    Some(s) => *s = (s.0, s.1 + 1, s.2 + u64::from(p.items), s.3 + p.bytes),
                    None => seen.push((p.pass, 1, u64::from(p.items), p.bytes)),
                }
            }
            for (pass, runs, items, bytes) in seen {
                let _ = writeln!(text, "{:<16} {pass:<24} {runs:>5} {items:>12} {bytes:>14}", shown(stage));
            }
        }
        let _ = writeln!(text, "\n{:<16} {:<24} {:>5} {:>14}", "stage", "buffer", "count", "bytes");
        let mut seen: Vec<(&str, &str, u32, u64)> = Vec::new();
        for b in &self.buffers {
            match seen.iter_mut().find(|s| (s.0, s.1) == (b.stage, b.label.as_str())) {
                Some(s) => *s = (s.0, s.1, s.2 + 1, s.3 + b.bytes),
                None => seen.push((b.stage, &b.label, 1, b.bytes)),
            }
        }
        for (stage, label, count, bytes) in seen {
            let stage = if stage.is_empty() { "scene, picture" } else { stage };
            let _ = writeln!(text, "{stage:<16} {label:<24} {count:>5} {bytes:>14}");
        }
        let _ = writeln!(
            text,
            "{} passes, {} pipelines, {} buffers, {} bytes in all",
            self.passes.len(),
            self.pipelines().len(),
            self.buffers.len(),
            self.bytes()
        );
        match self.counts {
            Counts::VoxelCones(c) => {
                let _ = writeln!(text, "{} leaves, {} voxels, {} of them lit", c.leaves, c.voxels, c.lit);
            }
            Counts::VisibilityFilter(c) => {
                let _ = writeln!(text, "{} proxies on the surfaces", c.proxies);
            }
            _ => {}
        }
        let _ = writeln!(text, "\n{:<12} {:>6}  runs again", "change of", "passes");
        for (change, passes) in &self.again {
            let list: Vec<&str> = stages(passes).into_iter().map(shown).collect();
            let list = if list.is_empty() { "nothing".to_owned() } else { list.join(", ") };
            let _ = writeln!(text, "{:<12} {:>6}  {list}", change.name(), passes.len());
        }
        text
    }
}
