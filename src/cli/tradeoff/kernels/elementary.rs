//! The elementary functions: ours, the system's, the driver's.

use super::Settings;
use super::case::{Case, Each, Head, Measure, NATIVE, OnDevice, SOFTWARE, Unit, each, number};
use super::device::Work;
use super::draw::{Random, list};
use super::truth;
use std::f64::consts::{PI, TAU};
use twinlight_kernels::math::{self, strict};
use twinlight_kernels::passes::elementary::function;
use twinlight_kernels::passes::evaluate_vector;

/// A function of one or two numbers; y is 0 for those of one.
pub(super) struct Function {
    pub head: Head,
    /// Its number in the pass that evaluates elementary functions.
    pub id: u32,
    draw: fn(&mut Random) -> (f32, f32),
    truth: fn(f64, f64) -> f64,
    /// Truths below this count in units of this one's last place.
    least: f64,
    calls: Calls,
}

/// Functions of one number are timed as such.
enum Calls {
    One(Each<f32, [f32; 1]>, Vec<Other<f32>>),
    Two(Each<(f32, f32), [f32; 1]>, Vec<Other<(f32, f32)>>),
}

type Other<I> = (&'static str, Each<I, [f32; 1]>);

impl Function {
    /// A function of one number.
    pub(super) fn one(
        head: Head,
        id: u32,
        draw: fn(&mut Random) -> (f32, f32),
        truth: fn(f64, f64) -> f64,
        kernel: impl Fn(f32) -> f32 + 'static,
    ) -> Self {
        let calls = Calls::One(each(move |x: &f32| [kernel(*x)]), Vec::new());
        Self { head, id, draw, truth, least: 0.0, calls }
    }

    /// A function of two numbers.
    fn two(
        head: Head,
        id: u32,
        draw: fn(&mut Random) -> (f32, f32),
        truth: fn(f64, f64) -> f64,
        kernel: impl Fn(f32, f32) -> f32 + 'static,
    ) -> Self {
        let calls = Calls::Two(each(move |p: &(f32, f32)| [kernel(p.0, p.1)]), Vec::new());
        Self { head, id, draw, truth, least: 0.0, calls }
    }

    /// Adds another way on the CPU.
    pub(super) fn other(mut self, name: &'static str, way: impl Fn(f32, f32) -> f32 + 'static) -> Self {
        match &mut self.calls {
            Calls::One(_, others) => others.push((name, each(move |x: &f32| [way(*x, 0.0)]))),
            Calls::Two(_, others) => others.push((name, each(move |p: &(f32, f32)| [way(p.0, p.1)]))),
        }
        self
    }

    fn native(self, way: impl Fn(f32, f32) -> f32 + 'static) -> Self {
        self.other(NATIVE, way)
    }

    fn least(mut self, least: f64) -> Self {
        self.least = least;
        self
    }

    /// The function with its inputs.
    pub(super) fn case(self, settings: &Settings) -> Box<dyn Measure> {
        let (truth, least, id) = (self.truth, self.least, self.id);
        let name = format!("{} {}", self.head.kernel, self.head.domain);
        let pairs = list(&name, settings.numbers, self.draw);
        let software = self.head.variant == SOFTWARE;
        let error = move |x: f32, y: f32, got: f32| truth::ulp(got, truth(f64::from(x), f64::from(y)), least);
        match self.calls {
            Calls::One(strict, others) => Box::new(Case {
                head: self.head,
                inputs: pairs.into_iter().map(|p| p.0).collect(),
                strict,
                others,
                error: Box::new(move |_, x, got| error(*x, 0.0, got[0])),
                device: Some(OnDevice {
                    work: Box::new(move |x| Work::Elementary(id, [x.to_vec(), vec![0.0; x.len()]])),
                    read: number::<0>,
                    software,
                }),
            }),
            Calls::Two(strict, others) => Box::new(Case {
                head: self.head,
                inputs: pairs,
                strict,
                others,
                error: Box::new(move |_, p, got| error(p.0, p.1, got[0])),
                device: Some(OnDevice {
                    work: Box::new(move |pairs| {
                        Work::Elementary(
                            id,
                            [pairs.iter().map(|p| p.0).collect(), pairs.iter().map(|p| p.1).collect()],
                        )
                    }),
                    read: number::<0>,
                    software,
                }),
            }),
        }
    }
}

fn head(kernel: &'static str, domain: &'static str, stated: f64) -> Head {
    Head::strict(kernel, domain, Unit::Ulp).stated(stated)
}

/// Half of the numbers of either kind.
fn either(r: &mut Random, one: fn(&mut Random) -> f32, other: fn(&mut Random) -> f32) -> (f32, f32) {
    (if r.bits() & 1 == 0 { one(r) } else { other(r) }, 0.0)
}

/// All of them, in the order of the documentation's table.
pub(super) fn functions() -> Vec<Function> {
    let mut all = exponentials();
    all.extend(logarithms());
    all.extend(trigonometry());
    all.extend(powers());
    all.extend(roots());
    all
}

fn exponentials() -> Vec<Function> {
    vec![
        Function::one(
            head("exp2", "-126 to 126", 1.24),
            function::EXP2,
            |r| either(r, |r| r.range(-126.0, 126.0), |r| r.signed(1e-6, 126.0)),
            |x, _| x.exp2(),
            math::exp2,
        )
        .native(|x, _| x.exp2()),
        Function::one(
            head("exp", "-87 to 88", 0.96),
            function::EXP,
            |r| either(r, |r| r.range(-87.0, 88.0), |r| r.signed(1e-6, 87.0)),
            |x, _| x.exp(),
            math::exp,
        )
        .native(|x, _| x.exp()),
        Function::one(
            head("exp_minus_one", "-17 to 88", 1.43),
            function::EXP_MINUS_ONE,
            |r| either(r, |r| r.range(-17.0, 88.0), |r| r.signed(1e-9, 17.0)),
            |x, _| x.exp_m1(),
            math::exp_minus_one,
        )
        .native(|x, _| x.exp_m1()),
        Function::one(
            head("erf", "-3.9 to 3.9", 1.31),
            function::ERF,
            |r| either(r, |r| r.range(-3.9, 3.9), |r| r.signed(1e-9, 3.9)),
            |x, _| truth::erf(x),
            math::erf,
        ),
    ]
}

fn logarithms() -> Vec<Function> {
    /// Log-uniform.
    fn positive(r: &mut Random) -> (f32, f32) {
        (r.positive(1.2e-38, 3e38), 0.0)
    }
    fn near_one(r: &mut Random) -> (f32, f32) {
        (r.range(0.7, 1.5), 0.0)
    }
    let log2 = |domain, draw| {
        let log2 =
            Function::one(head("log2", domain, 1.51), function::LOG2, draw, |x, _| x.log2(), math::log2);
        log2.native(|x, _| x.log2())
    };
    let ln = |domain, draw| {
        let ln = Function::one(head("ln", domain, 0.86), function::LN, draw, |x, _| x.ln(), math::ln);
        ln.native(|x, _| x.ln())
    };
    vec![
        log2("1.2e-38 to 3e38", positive as fn(&mut Random) -> (f32, f32)),
        log2("0.7 to 1.5", near_one),
        ln("1.2e-38 to 3e38", positive as fn(&mut Random) -> (f32, f32)),
        ln("0.7 to 1.5", near_one),
        Function::one(
            head("ln_one_plus", "-0.999999 to 1e30", 0.80),
            function::LN_ONE_PLUS,
            |r| either(r, |r| -r.positive(1e-9, 0.999_999), |r| r.positive(1e-9, 1e30)),
            |x, _| x.ln_1p(),
            math::ln_one_plus,
        )
        .native(|x, _| x.ln_1p()),
    ]
}

/// Sines below this count in units of its last place, as the documentation does.
const LEAST_SINE: f64 = 1.0 / 1024.0;

fn trigonometry() -> Vec<Function> {
    let turns: fn(&mut Random) -> (f32, f32) = |r| (r.range(-4.0, 4.0), 0.0);
    let one_turn: fn(&mut Random) -> (f32, f32) = |r| (r.range(-PI, PI), 0.0);
    let many: fn(&mut Random) -> (f32, f32) = |r| (r.range(-1000.0, 1000.0), 0.0);
    let tau = TAU as f32;
    let mut all = vec![
        Function::one(
            head("sin_turn", "-4 to 4 turns", 1.97),
            function::SIN_TURN,
            turns,
            |t, _| truth::sin_cos_turn(t).0,
            |t| math::sin_cos_turn(t).0,
        )
        .native(move |t, _| (t * tau).sin()),
        Function::one(
            head("cos_turn", "-4 to 4 turns", 1.97),
            function::COS_TURN,
            turns,
            |t, _| truth::sin_cos_turn(t).1,
            |t| math::sin_cos_turn(t).1,
        )
        .native(move |t, _| (t * tau).cos()),
    ];
    for (domain, draw) in [("-π to π", one_turn), ("-1000 to 1000", many)] {
        let sin = head("sin", domain, 1.56);
        all.push(
            Function::one(sin, function::SIN, draw, |x, _| x.sin(), |x| math::sin_cos(x).0)
                .native(|x, _| x.sin()),
        );
        let cos = head("cos", domain, 1.56);
        all.push(
            Function::one(cos, function::COS, draw, |x, _| x.cos(), |x| math::sin_cos(x).1)
                .native(|x, _| x.cos()),
        );
    }
    let mut all: Vec<_> = all.into_iter().map(|f| f.least(LEAST_SINE)).collect();
    all.push(
        Function::one(
            head("acos", "-1 to 1", 1.16),
            function::ACOS,
            |r| either(r, |r| r.range(-1.0, 1.0), |r| 1.0 - r.positive(1e-7, 1e-2)),
            |x, _| x.acos(),
            math::acos,
        )
        .native(|x, _| x.acos()),
    );
    all.push(
        Function::two(
            head("atan2", "2^-12 to 2^12, all quadrants", 1.55),
            function::ATAN2,
            |r| (r.signed(2f64.powi(-12), 4096.0), r.signed(2f64.powi(-12), 4096.0)),
            f64::atan2,
            math::atan2,
        )
        .native(f32::atan2),
    );
    all
}

fn powers() -> Vec<Function> {
    /// Base and exponent whose power is a normal number.
    fn wide(r: &mut Random) -> (f32, f32) {
        loop {
            let (x, y) = (r.positive(1.0 / 64.0, 4.0), r.range(-128.0, 128.0));
            if (1e-37..1e38).contains(&f64::from(x).powf(f64::from(y))) {
                return (x, y);
            }
        }
    }
    fn gamma(r: &mut Random) -> (f32, f32) {
        (r.positive(1e-4, 1.0), 1.0 / 2.2)
    }
    let draws = [("x^y, |y| to 128", wide as fn(&mut Random) -> (f32, f32)), ("x^(1/2.2)", gamma)];
    let mut all = Vec::new();
    for (domain, draw) in draws {
        all.push(
            Function::two(head("pow", domain, 1.7), function::POW, draw, f64::powf, math::pow)
                .native(f32::powf),
        );
        // 1.1e-7·|y log₂ x| + 1.6e-7, in units of 2⁻²⁴ at the worst.
        let stated = if domain.contains("128") { 237.0 } else { 14.0 };
        let fast = head("pow_fast", domain, stated);
        all.push(Function::two(fast, function::POW_FAST, draw, f64::powf, math::pow_fast).native(f32::powf));
    }
    all
}

fn roots() -> Vec<Function> {
    let positive: fn(&mut Random) -> (f32, f32) = |r| (r.positive(1.2e-38, 3e38), 0.0);
    let moderate: fn(&mut Random) -> (f32, f32) = |r| (r.signed(1e-18, 1e18), r.signed(1e-18, 1e18));
    let domain = "1.2e-38 to 3e38";
    let software = |kernel, domain| {
        let mut head = head(kernel, domain, 0.5);
        head.variant = SOFTWARE.into();
        head
    };
    let (sqrt, div) = (|x: f64, _: f64| x.sqrt(), |x: f64, y: f64| x / y);
    vec![
        Function::one(head("sqrt", domain, 0.5), function::SQRT, positive, sqrt, math::sqrt)
            .native(|x, _| x.sqrt()),
        Function::one(software("sqrt", domain), function::SQRT, positive, sqrt, strict::sqrt_software)
            .native(|x, _| x.sqrt()),
        Function::one(
            head("rsqrt", domain, 1.5),
            function::RSQRT,
            positive,
            |x, _| 1.0 / x.sqrt(),
            math::rsqrt,
        )
        .native(|x, _| 1.0 / x.sqrt()),
        Function::two(head("div", "1e-18 to 1e18", 0.5), function::DIV, moderate, div, math::div)
            .native(|x, y| x / y),
        Function::two(software("div", "1e-18 to 1e18"), function::DIV, moderate, div, strict::div_software)
            .native(|x, y| x / y),
        Function::one(
            head("floor", "1e-3 to 1e9", 0.0),
            function::FLOOR,
            |r| (r.signed(1e-3, 1e9), 0.0),
            |x, _| x.floor(),
            math::floor,
        )
        .native(|x, _| x.floor()),
    ]
}

/// Whole powers by squaring: one with a pass, others by degree.
pub(super) fn whole_powers(settings: &Settings) -> Vec<Box<dyn Measure>> {
    fn degree<const N: u32>(settings: &Settings) -> Box<dyn Measure> {
        let on_device = || OnDevice {
            work: Box::new(|x: &[f32]| {
                let a = x.iter().map(|x| glam::Vec4::new(0.0, *x, 0.0, 0.0)).collect();
                Work::Vector(evaluate_vector::function::SCALARS, [a, vec![glam::Vec4::ONE; x.len()]])
            }),
            read: number::<2>,
            software: false,
        };
        Box::new(Case {
            // Each product adds half a unit of the last place, of the least mantissa at the worst.
            head: Head::new("powi", &format!("degree {N}"), "0.5 to 1.5", Unit::Ulp).stated(f64::from(N - 1)),
            inputs: list("powi", settings.numbers, |r| r.range(0.5, 1.5)),
            strict: each(|x: &f32| [math::powi(*x, N)]),
            others: vec![(NATIVE, each(|x: &f32| [x.powi(N as i32)]))],
            error: Box::new(|_, x, got| truth::ulp(got[0], f64::from(*x).powi(N as i32), 0.0)),
            device: (N == 5).then(on_device),
        })
    }
    vec![
        degree::<2>(settings),
        degree::<4>(settings),
        degree::<5>(settings),
        degree::<8>(settings),
        degree::<16>(settings),
        degree::<32>(settings),
    ]
}
