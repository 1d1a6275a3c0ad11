//! Which effects fit into a time?

use super::Renderer;
use crate::backend::{Backend, BackendError};
use crate::plan::{Effect, Plan, Request};
use crate::technique::View;
use std::time::{Duration, Instant};

/// What is left out first: what adds least for its time.
const ORDER: [Effect; 6] = [
    Effect::FurtherBounces,
    Effect::SpecularBounce,
    Effect::SoftShadows,
    Effect::ProxyBounce,
    Effect::Bounce,
    Effect::Gloss,
];

impl<B: Backend> Renderer<B> {
    /// The request's plan with as many effects as are expected to fit into a time, and that time.
    ///
    /// Two trials of each plan, at a quarter and an eighth of the picture's sides, tell what its passes take with and without pixels; knobs that name
    /// a number of pixels count as pixels do. Where nothing more can be left out, that plan is returned whatever it takes.
    ///
    /// # Errors
    /// Knobs out of range, and what the backend reports.
    pub fn plan_within(
        &mut self,
        request: &Request,
        budget: Duration,
    ) -> Result<(Plan, Duration), BackendError> {
        let mut request = request.clone();
        loop {
            let plan = self.plan(&request)?;
            let expected = self.expected(&plan)?;
            let next = ORDER.into_iter().find(|&e| plan.calls(e));
            match next {
                Some(effect) if expected > budget => {
                    let kept = plan.effects().into_iter().filter(|&e| e != effect).collect();
                    request.effects = Some(kept);
                }
                _ => return Ok((plan, expected)),
            }
        }
    }

    /// What the passes of a plan's picture are expected to take from nothing.
    fn expected(&mut self, plan: &Plan) -> Result<Duration, BackendError> {
        let whole = f64::from(plan.view.width) * f64::from(plan.view.height);
        let mut measured = Vec::new();
        for part in [8, 4] {
            let side = |x: u32| x.div_ceil(part).max(1);
            let view = View { width: side(plan.view.width), height: side(plan.view.height), ..plan.view };
            let trial = Plan { view, ..plan.without_pixels() };
            self.forget();
            let begun = Instant::now();
            let frame = self.render(&trial)?;
            let wall = begun.elapsed().as_secs_f64();
            let passes: f64 = frame.rendered.timings.iter().map(|t| t.nanoseconds * 1e-9).sum();
            // Devices without timestamps tell nothing of their passes.
            let seconds = if passes.is_nan() { wall } else { passes };
            measured.push((f64::from(view.width) * f64::from(view.height), seconds));
        }
        self.forget();
        let [(small, little), (large, more)] = [measured[0], measured[1]];
        let slope = if large > small { ((more - little) / (large - small)).max(0.0) } else { 0.0 };
        Ok(Duration::from_secs_f64((more + slope * (whole - large)).max(0.0)))
    }
}
