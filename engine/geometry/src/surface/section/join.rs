//! Lines that are one, and lines that go on in the next rectangle, on the next patch, across a seam
//! or through a pole.

use super::{
    line::{Line, SectionPoint},
    near::Near,
};
use crate::space::Vector;
use flankfit_numerics::cancel::checkpoint;

/// Least cosine between tangents of lines that go on.
const ALIKE: f64 = 1.0 - 1e-9;

/// Keeps only the first of lines that coincide (along a seam, or a side that two pieces share).
pub(super) fn without_twins(lines: Vec<Line>, near: f64) -> Vec<Line> {
    let mut kept: Vec<Line> = Vec::new();
    let mut known = Near::within(10.0 * near);
    for line in lines {
        checkpoint();
        let [a, b] = ends(&line);
        let same = known.of(&a).any(|(k, _)| is_twin(&line, &kept[k], 10.0 * near));
        if !same {
            known.insert(kept.len(), a);
            known.insert(kept.len(), b);
            kept.push(line);
        }
    }
    kept
}

fn is_twin(line: &Line, other: &Line, near: f64) -> bool {
    let ([a, b], [c, d]) = (ends(line), ends(other));
    let sides = (a - c).norm().max((b - d).norm()).min((a - d).norm().max((b - c).norm()));
    // chords bend away from the curve by the square of their length
    sides <= near
        && (length(line) - length(other)).abs() <= 1e-5 * length(other)
        && (middle(line) - middle(other)).norm() <= 1e-2 * length(other)
}

fn ends(line: &Line) -> [Vector; 2] {
    [line.points[0].point, line.points[line.points.len() - 1].point]
}

fn length(line: &Line) -> f64 {
    line.points[line.points.len() - 1].length
}

fn middle(line: &Line) -> Vector {
    let half = 0.5 * length(line);
    let k = line.points.partition_point(|point| point.length < half).clamp(1, line.points.len() - 1);
    let (a, b) = (line.points[k - 1], line.points[k]);
    let share = (half - a.length) / (b.length - a.length);
    a.point * (1.0 - share) + b.point * share
}

/// An end of a line: the line, and whether it is its start.
type End = (usize, bool);

/// Joins lines whose ends meet within `near` with one tangent, but at the `branches`.
pub(super) fn joined(lines: Vec<Line>, branches: &[Vector], near: f64) -> Vec<Line> {
    let next = partners(&lines, branches, near);
    let mut lines: Vec<Option<Line>> = lines.into_iter().map(Some).collect();
    let mut all = Vec::new();
    // lines with a loose end first, then what runs in circles
    for loose in [true, false] {
        for k in 0..lines.len() {
            checkpoint();
            let loose_end = [true, false].into_iter().find(|start| next[slot((k, *start))].is_none());
            let start = if loose { loose_end } else { Some(true) };
            let Some(start) = start else { continue };
            let Some(mut line) = lines[k].take() else { continue };
            if line.closed {
                all.push(line);
                continue;
            }
            if !start {
                reverse(&mut line);
            }
            let mut leaving = next[slot((k, !start))];
            while let Some(((other, at_start), gap)) = leaving {
                let Some(mut tail) = lines[other].take() else {
                    close(&mut line, gap);
                    break;
                };
                if !at_start {
                    reverse(&mut tail);
                }
                append(&mut line, tail, gap);
                leaving = next[slot((other, !at_start))];
            }
            all.push(line);
        }
    }
    all
}

/// Index of an end of a line among those of all lines.
fn slot((line, start): End) -> usize {
    2 * line + usize::from(!start)
}

/// For every end the one that goes on from it, with the distance.
fn partners(lines: &[Line], branches: &[Vector], near: f64) -> Vec<Option<(End, f64)>> {
    let all = || (0..lines.len()).filter(|k| !lines[*k].closed).flat_map(|k| [(k, true), (k, false)]);
    let mut places = Near::within(near);
    let mut crossings = Near::within(near);
    all().for_each(|end| places.insert(slot(end), outward(lines, end).0));
    branches.iter().for_each(|branch| crossings.insert(0, *branch));
    let mut next: Vec<Option<(End, f64)>> = vec![None; 2 * lines.len()];
    for end in all() {
        checkpoint();
        let (point, out) = outward(lines, end);
        if next[slot(end)].is_some() || crossings.of(&point).next().is_some() {
            continue;
        }
        let found = places
            .of(&point)
            .map(|(slot, gap)| ((slot / 2, slot % 2 == 0), gap))
            .filter(|(other, _)| *other != end && next[slot(*other)].is_none())
            .filter(|(other, _)| -out.dot(&outward(lines, *other).1) >= ALIKE)
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((other, gap)) = found {
            next[slot(end)] = Some((other, gap));
            next[slot(other)] = Some((end, gap));
        }
    }
    next
}

/// The place of an end, and the direction out of the line there.
fn outward(lines: &[Line], (line, start): End) -> (Vector, Vector) {
    let points = &lines[line].points;
    if start {
        (points[0].point, -points[0].tangent)
    } else {
        let last = points[points.len() - 1];
        (last.point, last.tangent)
    }
}

fn close(line: &mut Line, gap: f64) {
    line.closed = true;
    line.error = line.error.max(gap);
    if let [first, .., last] = &mut line.points[..] {
        *last = SectionPoint { length: last.length, ..*first };
    }
}

fn reverse(line: &mut Line) {
    let whole = length(line);
    line.points.reverse();
    for point in &mut line.points {
        point.length = whole - point.length;
        point.tangent = -point.tangent;
        point.slope = point.slope.map(|x| -x);
    }
}

fn append(line: &mut Line, tail: Line, gap: f64) {
    let start = length(line);
    line.points.extend(tail.points.into_iter().skip(1).map(|p| SectionPoint { length: start + p.length, ..p }));
    line.touching |= tail.touching;
    line.error = line.error.max(tail.error).max(gap);
}
