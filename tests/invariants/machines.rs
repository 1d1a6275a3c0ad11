//! Are the bits the same for any number of threads, on the strict GPU, and in every run?

use crate::support::{same_bits, strict_gpu};
use crate::{render_on, subjects};
use twinlight::backend::Cpu;
use twinlight::technique::LightPart;

#[test]
fn threads_runs_and_the_strict_gpu_do_not_matter() {
    for (scene, technique) in subjects() {
        let camera = scene.view();
        let on = |threads: usize| {
            render_on(Cpu::new(Some(threads)).unwrap(), &scene, &camera, &technique, LightPart::All)
        };
        let one = on(1);
        for threads in [2, 7, 16, 7] {
            assert!(same_bits(&one, &on(threads)), "{}: {threads} threads", technique.name());
        }
        let mut other = scene.clone();
        other.triangles[0].p0.x += 0.25;
        let other = render_on(Cpu::new(Some(2)).unwrap(), &other, &camera, &technique, LightPart::All);
        assert!(!same_bits(&one, &other), "{}: another scene is no other picture", technique.name());
        let Some(gpu) = strict_gpu() else { continue };
        let gpu = render_on(gpu, &scene, &camera, &technique, LightPart::All);
        assert!(same_bits(&one, &gpu), "{}: strict GPU", technique.name());
    }
}
