//! Which scenes are in the tables of error and time, and what are their pictures compared with?

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use twinlight::picture::Picture;
use twinlight::report::error::{PictureError, picture_error};
use twinlight::scene::{Camera, Scene, bvh::Bvh, light};
use twinlight::technique::View;
use twinlight::technique::reference::{self, Bounces, Reference};

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Pixels along a side of the pictures.
pub const SIDE: u32 = 512;
/// Pixels along a side of what is compared.
pub const COARSE: u32 = 128;

/// A scene and how it is looked at.
pub struct Subject {
    pub name: &'static str,
    pub scene: Scene,
    pub camera: Camera,
}

/// The built-in Cornell boxes, and those scenes that the folder `TWINLIGHT_SCENES` has; `only` one, if it is named.
pub fn subjects(only: Option<&str>) -> Result<Vec<Subject>> {
    let mut all = Vec::new();
    for name in ["cornell-box", "cornell-glossy"] {
        let scene = Scene::open(name)?;
        let camera = scene.view();
        all.push(Subject { name, scene, camera });
    }
    let camera = |eye: [f32; 3], target: [f32; 3], fov| Camera {
        eye: eye.into(),
        target: target.into(),
        up: glam::Vec3::Y,
        fov,
    };
    let low = camera([0.0, 0.8, 3.2], [0.0, 0.8, 0.0], 36.0);
    let files = [
        ("cornell-glossy.glb", low, light::parse_spot("-0.6,1.5,0.6:0.9,-1.2,-0.7:4,4,4:35")?),
        (
            "cornell-original.glb",
            camera([0.0, 1.0, 3.4], [0.0, 1.0, 0.0], 39.0),
            light::parse_point("0,1.8,0:2,2,2")?,
        ),
        (
            "sponza.glb",
            camera([-11.0, 1.7, -0.5], [8.0, 4.5, 0.0], 60.0),
            light::parse_sun("0.25,-1,0.15:12,11,9.5")?,
        ),
        (
            "sibenik.glb",
            camera([-14.0, 4.0, 0.0], [10.0, 7.0, 0.0], 65.0),
            light::parse_point("0,8,0:120,115,100")?,
        ),
    ];
    let folder = std::env::var_os("TWINLIGHT_SCENES").map(PathBuf::from).unwrap_or_default();
    for (name, camera, lamp) in files {
        let path = folder.join(name);
        if !path.is_file() {
            eprintln!("left out: {name} is not in the folder TWINLIGHT_SCENES");
            continue;
        }
        let mut scene = Scene::open(&path.display().to_string())?;
        scene.lights = vec![lamp];
        all.push(Subject { name, scene, camera });
    }
    all.retain(|s| only.is_none_or(|o| o == s.name));
    Ok(all)
}

/// The reference's indirect light for a subject; prints its mean and noise.
pub fn reference(subject: &Subject, bounces: u32, samples: u32) -> Result<Picture> {
    let tree = Bvh::build(&subject.scene.triangles, &subject.scene.materials)?;
    let view = View::new(&subject.camera, COARSE, COARSE)?;
    let settings = Reference { samples, bounces: Bounces::Count(bounces), ..Default::default() };
    let right = reference::render(&subject.scene, &tree, &view, &settings, &AtomicBool::new(false), |_| ());
    let s = right.statistics[1];
    let noise = 3.0 * s.pixel_standard_error / s.mean.element_sum();
    println!(
        "\n{}: mean indirect radiance {:.5}, reference noise {:.1} %\n",
        subject.name,
        s.mean.y,
        100.0 * noise
    );
    Ok(right.indirect)
}

/// The error of a picture, its blocks of pixels averaged.
pub fn error(picture: &Picture, right: &Picture) -> Result<PictureError> {
    Ok(picture_error(&picture.averaged(SIDE / COARSE), right).ok_or("sizes differ")?)
}
