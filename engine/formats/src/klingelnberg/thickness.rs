//! Tooth thickness: span and dimension over balls, and the profile shift that follows from them.
//!
//! For external gears only. On the base circle a tooth of profile shift x has the arc `s_b = d_b
//! ((π/2 + 2 x tan α_n)/z + inv α_t)`, a span over k teeth is `W_k = ((k − 1) p_bt + s_b) cos β_b`,
//! and a ball of diameter D has its centre where `inv α_K = D/(d_b cos β_b) − η_b`, with η_b half
//! the angle of a space on the base circle. Over balls it measures `2 r_K + D`, and with an odd
//! number of teeth the chord between two centres.

use std::f64::consts::{PI, TAU};

use super::{
    super::{
        gear_facts::GearFacts,
        note::{Notes, Remark},
    },
    Characteristic, Curves, Header, Statistic, Values,
};
use flankfit_gear::{
    Gear, Side,
    involute::{inv_of_roll, roll_of_inv},
};

/// Difference of x above which no allowance of the tooth thickness explains it: 0.15 modules.
const ALLOWANCE: f64 = 0.2;

/// Length over all places around the gear.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = ThicknessSpread)
)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// Least length.
    pub least: f64,
    /// Greatest length.
    pub greatest: f64,
}

/// Span and dimension over balls around the gear.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = ToothThickness)
)]
pub struct Thickness {
    /// k of W_k.
    pub span_teeth: usize,
    /// W_k.
    pub span_mm: Spread,
    /// Diameter of the balls of M_dK.
    pub ball_diameter_mm: Option<f64>,
    /// M_dK: over two balls in opposite spaces, or nearly opposite ones of an odd number of teeth.
    pub over_balls_mm: Option<Spread>,
    /// x_E, the generating profile shift coefficient that follows from the mean W_k.
    pub profile_shift: f64,
}

impl Curves {
    /// Returns the gear of the header; notes a profile shift that contradicts the places of
    /// contact.
    pub fn gear(&self, notes: &mut Notes) -> GearFacts {
        let facts = self.header.gear(notes);
        let gear = facts.gear_data().ok().and_then(|data| Gear::new(data).ok());
        let measured = gear.and_then(|gear| self.thickness(&gear)).map(|found| (Figure::Span, found.span_mm.mean));
        self.header.compare(&facts, measured, notes);
        facts
    }

    /// Tooth thickness from the places where the pitch measurement touched both flanks of each
    /// tooth: centres of the ball of code 102, in the plane of rotation. `None` if places are
    /// missing, for internal gears, or if k (code 281) is not given.
    ///
    /// In known files the table turns so that the polar angle of a place on the gear is that of its
    /// point plus the angle of the table.
    pub fn thickness(&self, gear: &Gear) -> Option<Thickness> {
        let teeth = gear.data().teeth as usize;
        let radius = 0.5 * self.header.number(102)?;
        let k = self.header.whole(281).filter(|k| (1..teeth).contains(k))?;
        if gear.outward() < 0.0 || self.contacts.len() < 2 * teeth {
            return None;
        }
        // where the involutes of the flanks begin on the base circle
        let mut flanks = [vec![f64::NAN; teeth], vec![f64::NAN; teeth]];
        let base = gear.base_radius();
        for contact in &self.contacts {
            let tooth = (contact.tooth as usize).checked_sub(1).filter(|tooth| *tooth < teeth)?;
            let [x, y, _] = contact.point;
            let alpha = (base / x.hypot(y)).acos();
            let off = radius / (base * gear.base_helix_angle().cos());
            let begins = y.atan2(x) + contact.phi.to_radians() + contact.side.sign() * (involute(alpha) - off);
            flanks[usize::from(contact.side == Side::Right)][tooth] = begins;
        }
        let [left, right] = &flanks;
        // teeth are counted against the angles, so that the right flank of a later tooth follows
        let arc = |i: usize| (left[i] - right[(i + k - 1) % teeth]).rem_euclid(TAU);
        let along = base * gear.base_helix_angle().cos();
        let span = spread((0..teeth).map(|i| along * arc(i)))?;
        let profile_shift = shift_of_span(&Base::of(gear), k, span.mean);
        // a file of another sense of rotation gives thicknesses that no gear has
        if !(profile_shift.abs() <= 2.0) {
            return None;
        }
        let ball = self.header.number(28).filter(|ball| *ball > 0.0);
        let over_balls = ball.and_then(|ball| over_balls(gear, ball, left, right));
        Some(Thickness {
            span_teeth: k,
            span_mm: span,
            ball_diameter_mm: ball,
            over_balls_mm: over_balls,
            profile_shift,
        })
    }
}

impl Values {
    /// Returns the gear of the header; notes a profile shift that contradicts the printed W_k or
    /// M_dK.
    pub fn gear(&self, notes: &mut Notes) -> GearFacts {
        let facts = self.header.gear(notes);
        let printed = |of| {
            let mut results = self.results.iter();
            results
                .find(|found| found.characteristic == Some(of) && found.statistic == Statistic::Mean)?
                .reading
                .value()
        };
        let span = printed(Characteristic::Span).map(|value| (Figure::Span, value));
        let balls = || printed(Characteristic::DimensionOverBalls).map(|value| (Figure::OverBalls, value));
        self.header.compare(&facts, span.or_else(balls), notes);
        facts
    }
}

/// Figure from which a tooth thickness follows.
#[derive(Clone, Copy)]
enum Figure {
    Span,
    OverBalls,
}

impl Header {
    /// Returns the value of a code, if it is a whole number above 0.
    fn whole(&self, code: u32) -> Option<usize> {
        let value = self.number(code)?;
        (value.fract() == 0.0 && (1.0..=1e6).contains(&value)).then_some(value as usize)
    }

    /// Notes a profile shift that no allowance reconciles with a measured figure or, without one,
    /// with the span that code 115 prescribes.
    fn compare(&self, facts: &GearFacts, measured: Option<(Figure, f64)>, notes: &mut Notes) {
        let asked = || self.get(115)?.numbers().next().filter(|span| *span > 0.0).map(|span| (Figure::Span, span));
        let (Some(header), Some((figure, value))) = (facts.profile_shift, measured.or_else(asked)) else { return };
        let Some(base) = Base::of_facts(facts).filter(|_| !facts.is_internal()) else { return };
        let (figure, given) = match figure {
            Figure::Span => {
                let Some(k) = self.whole(281) else { return };
                ("W_k", shift_of_span(&base, k, value))
            }
            Figure::OverBalls => {
                let Some(ball) = self.number(28).filter(|ball| *ball > 0.0) else { return };
                ("M_dK", shift_over_balls(&base, ball, value))
            }
        };
        if (given - header).abs() > ALLOWANCE {
            let line = self.get(25).map_or(1, |line| line.line);
            notes.push(line, Remark::ProfileShiftContradicted { header, figure, value, given });
        }
    }
}

/// Gear data from which tooth thickness is computed.
struct Base {
    teeth: f64,
    module: f64,
    /// α_n and α_t.
    angles: [f64; 2],
    helix: f64,
}

impl Base {
    fn of(gear: &Gear) -> Self {
        let data = gear.data();
        let angles = [data.pressure_angle, gear.transverse_pressure_angle()];
        Base { teeth: gear.teeth(), module: data.normal_module, angles, helix: data.helix_angle }
    }

    fn of_facts(facts: &GearFacts) -> Option<Self> {
        let (normal, helix) = (facts.pressure_angle?, facts.helix_angle?);
        let angles = [normal, (normal.tan() / helix.cos()).atan()];
        Some(Base { teeth: f64::from(facts.teeth?), module: facts.normal_module?, angles, helix })
    }
}

fn shift_of_span(base: &Base, k: usize, span: f64) -> f64 {
    let [normal, transverse] = base.angles;
    let without = base.module * normal.cos() * (PI * (k as f64 - 0.5) + base.teeth * involute(transverse));
    (span - without) / (2.0 * base.module * normal.sin())
}

fn shift_over_balls(base: &Base, ball: f64, over: f64) -> f64 {
    let [normal, transverse] = base.angles;
    let chord = if base.teeth % 2.0 == 0.0 { 1.0 } else { (PI / (2.0 * base.teeth)).cos() };
    let base_diameter = base.teeth * base.module * transverse.cos() / base.helix.cos();
    let at_centre = involute((base_diameter / ((over - ball) / chord)).acos());
    let ball = ball / (base.teeth * base.module * normal.cos());
    base.teeth / (2.0 * normal.tan()) * (at_centre - involute(transverse) - ball + PI / (2.0 * base.teeth))
}

/// Returns M_dK over the pairs of opposite, or nearly opposite, spaces.
fn over_balls(gear: &Gear, ball: f64, left: &[f64], right: &[f64]) -> Option<Spread> {
    let teeth = left.len();
    let base = gear.base_radius();
    // radius and polar angle of the ball's centre in the space before tooth i
    let centre = |i: usize| {
        let space = (right[i] - left[(i + 1) % teeth]).rem_euclid(TAU);
        let involute = 0.5 * (ball / (base * gear.base_helix_angle().cos()) - space);
        let roll = (involute > 0.0).then(|| roll_of_inv(involute))?;
        Some((base * roll.hypot(1.0), right[i] - 0.5 * space))
    };
    let centres: Vec<(f64, f64)> = (0..teeth).map(centre).collect::<Option<_>>()?;
    let over = |i: usize| {
        let ((a, from), (b, to)) = (centres[i], centres[(i + teeth / 2) % teeth]);
        let chord = (a * a + b * b - 2.0 * a * b * (to - from).cos()).sqrt();
        if teeth.is_multiple_of(2) { a + b + ball } else { chord + ball }
    };
    spread((0..teeth).map(over))
}

fn spread(values: impl Iterator<Item = f64>) -> Option<Spread> {
    let mut sum = 0.0;
    let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut count = 0.0;
    for value in values {
        (sum, count) = (sum + value, count + 1.0);
        (least, greatest) = (least.min(value), greatest.max(value));
    }
    // NaN if a flank was not touched
    (sum / count).is_finite().then_some(Spread { mean: sum / count, least, greatest })
}

/// Returns the involute function of an angle.
fn involute(alpha: f64) -> f64 {
    inv_of_roll(alpha.tan())
}
