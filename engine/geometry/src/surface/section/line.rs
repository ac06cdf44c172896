//! Chains of places as curves: cubics with the true tangents, between places that are close enough
//! for the tolerance.

use super::{
    chain::Chain,
    field::{Field, Kind},
};
use crate::space::Vector;
use flankfit_numerics::cancel::checkpoint;

/// Halvings of a piece at most.
const DEEPEST: u32 = 20;
/// Places nearer to each other than this part of the surface's extent are one.
const ONE_PLACE: f64 = 1e-10;
/// Tolerances below this part of the surface's extent are out of reach.
const FINEST: f64 = 1e-13;
/// How often the length of a piece is found anew.
const LENGTHS: usize = 2;
/// Least cosine of the turn of a piece.
const LEAST_COSINE: f64 = 0.8;

/// A place on the section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPoint {
    /// Which patch of a patchwork it lies on, else 0.
    pub patch: usize,
    /// u and v on its patch.
    pub parameters: [f64; 2],
    /// The place itself.
    pub point: Vector,
    /// Unit tangent along the curve.
    pub tangent: Vector,
    /// Length of the curve up to here.
    pub length: f64,
    pub(super) slope: [f64; 2],
    pub(super) kind: Kind,
    /// How far rounding may have moved it.
    pub(super) rounding: f64,
}

/// How a curve is to be described.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Description {
    /// How far curve or chords may be from the section.
    pub tolerance: f64,
    /// Whether chords join the places, not cubics.
    pub chords: bool,
    /// Most places of all curves together.
    pub most: usize,
}

/// A line of the section within one rectangle.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub points: Vec<SectionPoint>,
    pub closed: bool,
    pub touching: bool,
    pub error: f64,
}

/// Result of tracing a chain of places.
pub(super) enum Traced {
    Line(Line),
    OnePlace,
    /// At one of its places the tangent is undetermined.
    Unclear,
}

/// The line through a chain.
pub(super) fn line(field: &Field<'_>, chain: &Chain, size: f64, how: Description) -> Result<Traced, TooMany> {
    let mut places = chain.places.clone();
    if chain.closed {
        places.extend(places.first().copied());
    }
    let last = places.len().saturating_sub(1);
    let mut apart: Vec<([f64; 2], Kind, Vector)> = Vec::with_capacity(places.len());
    for (k, (at, kind)) in places.into_iter().enumerate() {
        let point = field.at(at).jet.value;
        let near = |known: &Vector| (point - known).norm() <= ONE_PLACE * size;
        // of places that are one, the ends of the chain stay
        match apart.last() {
            Some((_, _, known)) if near(known) && k == last && apart.len() > 1 => {
                apart.pop();
                apart.push((at, kind, point));
            }
            Some((_, _, known)) if near(known) => {}
            _ => apart.push((at, kind, point)),
        }
    }
    if apart.len() < 2 {
        return Ok(Traced::OnePlace);
    }
    let Some(mut nodes) = (0..apart.len()).map(|k| node(field, &apart, k, chain.closed)).collect::<Option<Vec<_>>>()
    else {
        return Ok(Traced::Unclear);
    };
    if chain.closed
        && let [first, .., last] = &mut nodes[..]
    {
        *last = *first;
    }
    let mut line = Line {
        points: vec![nodes[0]],
        closed: chain.closed,
        touching: chain.places.iter().any(|(_, kind)| *kind == Kind::Touching),
        error: 0.0,
    };
    for pair in nodes.windows(2) {
        let how = Description { tolerance: how.tolerance.max(FINEST * size), ..how };
        piece(field, [&pair[0], &pair[1]], (how, ONE_PLACE * size), DEEPEST, &mut line)?;
    }
    Ok(if line.points.len() > 1 { Traced::Line(line) } else { Traced::OnePlace })
}

/// More places than are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooMany;

fn node(field: &Field<'_>, apart: &[([f64; 2], Kind, Vector)], k: usize, closed: bool) -> Option<SectionPoint> {
    let last = apart.len() - 1;
    let (at, kind, _) = apart[k];
    let before = if k > 0 {
        k - 1
    } else if closed {
        last - 1
    } else {
        0
    };
    let after = if k < last {
        k + 1
    } else if closed {
        1
    } else {
        last
    };
    point_at(field, at, kind, apart[after].2 - apart[before].2)
}

fn point_at(field: &Field<'_>, at: [f64; 2], kind: Kind, chord: Vector) -> Option<SectionPoint> {
    let local = field.at(at);
    let (tangent, slope) = local.tangent(kind, chord)?;
    // ends of lines and lines of contact are places without slope, not without height
    let rounding = if kind == Kind::Across { local.rounding(&field.normal, field.offset) } else { 0.0 };
    let point = local.jet.value;
    Some(SectionPoint { patch: field.patch, parameters: at, point, tangent, length: 0.0, slope, kind, rounding })
}

/// Cubic Hermite value at a share of a piece of this length.
fn hermite<const N: usize>(share: f64, length: f64, ends: [&[f64; N]; 2], slopes: [&[f64; N]; 2]) -> [f64; N] {
    let (t, s) = (share, 1.0 - share);
    let [a, b] = [s * s * (1.0 + 2.0 * t), t * t * (3.0 - 2.0 * t)];
    let [c, d] = [t * s * s * length, -t * t * s * length];
    std::array::from_fn(|k| a * ends[0][k] + b * ends[1][k] + c * slopes[0][k] + d * slopes[1][k])
}

/// A place that is no further than this part of the chord from where the cubic has it is the one
/// that is looked for.
const WHERE_EXPECTED: f64 = 0.05;

/// The place of the section at a share of a piece of this length.
fn between(field: &Field<'_>, a: &SectionPoint, b: &SectionPoint, share: f64, length: f64) -> Option<SectionPoint> {
    let kind = if a.kind == Kind::Touching || b.kind == Kind::Touching { Kind::Touching } else { Kind::Across };
    let guess = hermite(share, length, [&a.parameters, &b.parameters], [&a.slope, &b.slope]);
    let chord = b.point - a.point;
    let at = match kind {
        Kind::Across => passed(field, [a, b], share, guess, length),
        _ => None,
    };
    let found = point_at(field, at.unwrap_or_else(|| field.onto(guess, kind)), kind, chord)?;
    // what lies behind one of the ends is on another part of the section
    let ahead = |from: &Vector, to: &Vector| (to - from).dot(&chord) > 0.0;
    (kind == Kind::Touching || ahead(&a.point, &found.point) && ahead(&found.point, &b.point)).then_some(found)
}

/// Place where the section passes the plane across the chord at a share of a piece. In space the
/// section is smooth where parameters are not: near a pole they turn by a quarter within next to
/// nothing. So what counts is the distance in space from where the cubic expects it.
fn passed(field: &Field<'_>, [a, b]: [&SectionPoint; 2], share: f64, guess: [f64; 2], length: f64) -> Option<[f64; 2]> {
    let array = |v: &Vector| [v.x, v.y, v.z];
    let ends = [array(&a.point), array(&b.point)];
    let tangents = [array(&a.tangent), array(&b.tangent)];
    let chord = b.point - a.point;
    let along = chord.try_normalize(0.0)?;
    let expected = Vector::from(hermite(share, length, [&ends[0], &ends[1]], [&tangents[0], &tangents[1]]));
    let ([p, q], [s, t]) = (a.parameters, b.parameters);
    let mean = [p + share * (s - p), q + share * (t - q)];
    let mut best: Option<([f64; 2], f64)> = None;
    for start in [guess, mean, [p, t], [s, q], a.parameters, b.parameters] {
        let Some(at) = field.across(start, &along, along.dot(&expected)) else { continue };
        let off = (field.at(at).jet.value - expected).norm() / chord.norm();
        if best.is_none_or(|(_, least)| off < least) {
            best = Some((at, off));
        }
        if off <= WHERE_EXPECTED {
            break;
        }
    }
    best.filter(|(_, off)| *off <= 1.0).map(|(at, _)| at)
}

/// How far the curve that joins two places is from a third between them, at right angles to it.
fn distance(a: &SectionPoint, b: &SectionPoint, share: f64, length: f64, found: &SectionPoint, chords: bool) -> f64 {
    let off = if chords {
        let along = (b.point - a.point).normalize();
        let off = found.point - a.point;
        return (off - along * along.dot(&off)).norm();
    } else {
        let array = |v: &Vector| [v.x, v.y, v.z];
        let [p, q] = [array(&a.point), array(&b.point)];
        let [s, t] = [array(&a.tangent), array(&b.tangent)];
        found.point - Vector::from(hermite(share, length, [&p, &q], [&s, &t]))
    };
    (off - found.tangent * found.tangent.dot(&off)).norm()
}

/// Adds what follows the first place up to the second; pieces shorter than `least` are not divided.
fn piece(
    field: &Field<'_>,
    [a, b]: [&SectionPoint; 2],
    (how, least): (Description, f64),
    depth: u32,
    line: &mut Line,
) -> Result<(), TooMany> {
    checkpoint();
    let chord = b.point - a.point;
    let mut length = chord.norm();
    let mut middle = None;
    for _ in 0..LENGTHS {
        middle = between(field, a, b, 0.5, length);
        let Some(found) = &middle else { break };
        // Simpson's rule for the chord, which is the integral of the tangents
        let mean = (a.tangent + found.tangent * 4.0 + b.tangent) / 6.0;
        length = if mean.norm() > 0.5 { chord.norm() / mean.norm() } else { chord.norm() };
    }
    let (error, near) = middle.as_ref().map_or((chord.norm(), false), |middle| {
        let mut error = distance(a, b, 0.5, length, middle, how.chords);
        // what rounding does cannot be divided away
        let tolerance = how.tolerance.max(2.0 * middle.rounding);
        let turned = a.tangent.dot(&middle.tangent).min(b.tangent.dot(&middle.tangent));
        if turned < LEAST_COSINE || error > 0.5 * tolerance {
            return (error, false);
        }
        for share in [0.25, 0.75] {
            if let Some(found) = between(field, a, b, share, length) {
                error = error.max(distance(a, b, share, length, &found, how.chords));
            }
        }
        (error, error <= tolerance)
    });
    if !near
        && depth > 0
        && chord.norm() > least
        && let Some(middle) = middle
    {
        piece(field, [a, &middle], (how, least), depth - 1, line)?;
        return piece(field, [&middle, b], (how, least), depth - 1, line);
    }
    if line.points.len() >= how.most {
        return Err(TooMany);
    }
    let start = line.points.last().map_or(0.0, |last| last.length);
    // two places that are one
    if start + length <= start {
        return Ok(());
    }
    line.points.push(SectionPoint { length: start + length, ..*b });
    let rounding = middle.map_or(0.0, |middle| middle.rounding);
    line.error = line.error.max(error + rounding);
    Ok(())
}
