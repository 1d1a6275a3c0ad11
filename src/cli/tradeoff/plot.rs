//! How does error go with time? Drawn for a scene, over logarithmic axes.

use super::record::{Point, SceneRecord};
use crate::report::pareto::pareto_front;
use plotters::coord::Shift;
use plotters::prelude::*;

type Failed = Box<dyn std::error::Error>;

/// What goes upward.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Up {
    Indirect,
    All,
    Flip,
    FlipIndirect,
}

impl Up {
    pub(super) const ALL: [Self; 4] = [Self::Indirect, Self::All, Self::Flip, Self::FlipIndirect];

    /// Its part of the file's name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Indirect => "indirect",
            Self::All => "all",
            Self::Flip => "flip",
            Self::FlipIndirect => "flip-indirect",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Indirect => "relative RMSE of indirect light, %",
            Self::All => "relative RMSE of all light, %",
            Self::Flip => "mean HDR-FLIP of all light",
            Self::FlipIndirect => "mean HDR-FLIP of indirect light",
        }
    }

    fn of(self, p: &Point) -> Option<f64> {
        match self {
            Self::Indirect => p.indirect.map(|e| 100.0 * e.told()),
            Self::All => p.all.map(|e| 100.0 * e.told()),
            Self::Flip => p.flip,
            Self::FlipIndirect => p.flip_indirect,
        }
    }
}

/// Okabe and Ito's colours, and a mark for each technique.
const LOOKS: [(&str, RGBColor); 5] = [
    ("visibility-filter", RGBColor(213, 94, 0)),
    ("voxel-cones", RGBColor(0, 114, 178)),
    ("layered-rsm", RGBColor(0, 158, 115)),
    ("soft-gi", RGBColor(204, 121, 167)),
    ("reference", RGBColor(90, 90, 90)),
];

const SIZE: (u32, u32) = (760, 480);

/// Draws a scene's points; `None` where fewer than two have a place.
pub(super) fn draw(scene: &SceneRecord, up: Up) -> Result<Option<String>, Failed> {
    let place = |p: &Point| {
        let (x, y) = (p.seconds.median * 1e3, up.of(p)?);
        (x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite()).then_some((x, y))
    };
    let placed: Vec<(&Point, (f64, f64))> =
        scene.points.iter().filter_map(|p| Some((p, place(p)?))).collect();
    if placed.len() < 2 {
        return Ok(None);
    }
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        chart(&root, scene, up, &placed)?;
        root.present()?;
    }
    Ok(Some(svg))
}

fn chart(
    root: &DrawingArea<SVGBackend<'_>, Shift>,
    scene: &SceneRecord,
    up: Up,
    placed: &[(&Point, (f64, f64))],
) -> Result<(), Failed> {
    let least = |of: fn(&(f64, f64)) -> f64| placed.iter().map(|p| of(&p.1)).fold(f64::INFINITY, f64::min);
    let most = |of: fn(&(f64, f64)) -> f64| placed.iter().map(|p| of(&p.1)).fold(0.0, f64::max);
    root.fill(&WHITE)?;
    let (width, height) = scene.size;
    let mut chart = ChartBuilder::on(root)
        .caption(format!("{}, {width} × {height}", scene.name), ("sans-serif", 16))
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(62)
        .build_cartesian_2d(
            (least(|p| p.0) * 0.8..most(|p| p.0) * 1.25).log_scale(),
            (least(|p| p.1) * 0.8..most(|p| p.1) * 1.25).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_desc("time of a frame's passes, ms")
        .y_desc(up.title())
        .x_labels(16)
        .y_labels(16)
        .x_label_formatter(&short)
        .y_label_formatter(&short)
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 14))
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 225, 225))
        .draw()?;
    let mut front = front_of(placed);
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    // What is on it holds until the next is dear enough.
    let steps: Vec<_> =
        front.iter().zip(front.iter().skip(1)).flat_map(|(a, b)| [*a, (b.0, a.1), *b]).collect();
    if front.len() > 1 {
        let style = BLACK.stroke_width(1);
        chart
            .draw_series(LineSeries::new(steps, style))?
            .label("what no other beats")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], style));
    }
    for (name, colour) in LOOKS {
        let points: Vec<_> = placed.iter().filter(|p| p.0.technique == name).map(|p| p.1).collect();
        if points.is_empty() {
            continue;
        }
        let label = if name == "reference" { "path tracer, more and more paths" } else { name };
        if name == "reference" {
            chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
        }
        chart
            .draw_series(
                points.iter().map(|&at| EmptyElement::at(at) + Circle::new((0, 0), 3, colour.filled())),
            )?
            .label(label)
            .legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
    }
    let ring = BLACK.stroke_width(1);
    chart.draw_series(front.iter().map(|&at| EmptyElement::at(at) + Circle::new((0, 0), 6, ring)))?;
    chart
        .configure_series_labels()
        .label_font(("sans-serif", 13))
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200))
        .draw()?;
    Ok(())
}

/// The places of techniques that no other beats; the path tracer is what they are compared with.
fn front_of(placed: &[(&Point, (f64, f64))]) -> Vec<(f64, f64)> {
    let of = |p: &(&Point, (f64, f64))| if p.0.technique == "reference" { (f64::NAN, f64::NAN) } else { p.1 };
    let places: Vec<_> = placed.iter().map(of).collect();
    places.iter().zip(pareto_front(&places)).filter(|(_, front)| *front).map(|(place, _)| *place).collect()
}

/// Rounded to three digits, without the zeros after them.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn short(v: &f64) -> String {
    let digits = (2 - v.abs().max(1.0e-9).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
