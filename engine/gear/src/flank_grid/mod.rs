//! Nodes of a flank: points and unit normals over a list of profile values and a list of places on
//! the face width.
//!
//! A section z is the section 0 turned by `z tan β_b / r_b`. So sine and cosine are taken once for
//! each profile value and once for each z, and every node is one turned by the other: 1 million
//! nodes are bound by memory, and a point keeps to the involute within some units of the last
//! place.
//!
//! Modifications move a point by −relief along the *nominal* normal n. The normal answered is that
//! of the *modified* surface: with the local frame e_r, e_t, e_z of [`super::involute`], w = h tan
//! β_b e_t + e_z, the relief H and A = (L − s σ H cos β_b)/r_b it is the direction of
//!
//! `A n + H_L e_r + A cos² β_b (H_z + σ h tan β_b H_L) w`,
//!
//! which is orthogonal to both derivatives of P − H n. Where the modified profile has shrunk into
//! the base cylinder (A ≤ 0), n is kept.

mod warning;

use rayon::prelude::*;

use super::{
    Gear, Modifications, ProfileAxis, Side,
    involute::Flank,
    modification::{Column, Relief},
};
use flankfit_numerics::{
    cancel,
    check::Faults,
    words::{Shown, counted},
};
pub use warning::GridWarning;
use warning::warnings;

/// Most nodes of one grid.
pub const MOST_NODES: usize = 2_000_000;

/// Nodes that one thread takes at a time; fewer are not shared out.
const CHUNK: usize = 4096;

/// Which nodes are wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct GridSpec {
    /// Flank of the tooth.
    pub side: Side,
    /// Coordinate that profile values are given in.
    pub axis: ProfileAxis,
    /// Profile values of the rows, in that coordinate.
    pub values: Vec<f64>,
    /// z of every column, mm.
    pub positions: Vec<f64>,
    /// 1 is the tooth at the top; numbers go clockwise as the viewer sees them, up to z.
    pub tooth: u32,
}

/// Nodes in rows of one profile value each, z running fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct FlankGrid {
    /// Roll length of every row, mm.
    pub roll_lengths: Vec<f64>,
    /// Axial position of every column, mm.
    pub positions: Vec<f64>,
    /// Points, rows × columns, mm.
    pub points: Vec<[f64; 3]>,
    /// Unit normals, out of the material.
    pub normals: Vec<[f64; 3]>,
    /// Warnings about nodes off the flank that is really there.
    pub warnings: Vec<GridWarning>,
}

impl FlankGrid {
    /// The nodes of `spec`, modified or not.
    ///
    /// ```
    /// use flankfit_gear::{FlankGrid, Gear, GearData, GridSpec, ProfileAxis, Side};
    ///
    /// let gear = Gear::new(GearData::spur(52, 1.0))?;
    /// let spec = GridSpec {
    ///     side: Side::Left,
    ///     axis: ProfileAxis::Diameter,
    ///     values: vec![51.0, 52.0, 53.0],
    ///     positions: vec![0.0, 10.0],
    ///     tooth: 1,
    /// };
    /// let grid = FlankGrid::new(&gear, &spec, None)?;
    /// // Rows of one diameter each.
    /// let [x, y, z] = grid.points[2 * grid.columns() + 1];
    /// assert!((x.hypot(y) - 26.5).abs() < 1e-12 && z == 10.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(gear: &Gear, spec: &GridSpec, modifications: Option<&Modifications>) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let (rows, columns) = (spec.values.len(), spec.positions.len());
        for (path, count) in [("profile.values", rows), ("face_width_positions_mm", columns)] {
            if count == 0 {
                faults.push(path, "at least one place is needed");
            }
        }
        if rows.saturating_mul(columns) > MOST_NODES {
            let nodes = counted(rows.saturating_mul(columns), "node", "nodes");
            faults.push("profile.values", format_args!("{nodes}; a grid has at most {MOST_NODES}"));
        }
        if let Some(message) = gear.no_such_tooth(spec.tooth) {
            faults.push("tooth", message);
        }
        for (index, z) in spec.positions.iter().enumerate() {
            if !(z.abs() <= 1e6) {
                let path = format_args!("face_width_positions_mm[{index}]");
                faults.push(path, format_args!("{} is not a place on the axis", Shown(*z)));
            }
        }
        faults.into_result(())?;
        let rolls = spec.axis.roll_lengths(gear, &spec.values);
        let roll_lengths = rolls.map_err(|found| found.within("profile.values"))?;
        let warnings = warnings(gear, &roll_lengths, &spec.positions);
        let mut grid = FlankGrid {
            points: vec![[0.0; 3]; rows * columns],
            normals: vec![[0.0; 3]; rows * columns],
            positions: spec.positions.clone(),
            roll_lengths,
            warnings,
        };
        grid.fill(&Frame::new(gear, spec.side, spec.tooth), modifications.filter(|m| !m.is_none_on(spec.side)));
        Ok(grid)
    }

    /// The columns' number.
    pub fn columns(&self) -> usize {
        self.positions.len()
    }

    fn fill(&mut self, frame: &Frame, modifications: Option<&Modifications>) {
        let sections: Vec<Section> = self.positions.iter().map(|z| frame.section(*z)).collect();
        let columns: Option<Vec<Column>> =
            modifications.map(|m| self.positions.iter().map(|z| m.column(frame.side, *z)).collect());
        let width = sections.len();
        let rows = self.points.par_chunks_exact_mut(width).zip(self.normals.par_chunks_exact_mut(width));
        let rows = rows.zip(self.roll_lengths.par_iter()).with_min_len(CHUNK.div_ceil(width));
        let handle = cancel::current();
        rows.for_each(|((points, normals), roll)| {
            cancel::ask(handle.as_ref());
            let profile = frame.profile(*roll);
            let nodes = points.iter_mut().zip(normals).zip(&sections);
            match modifications.zip(columns.as_ref()) {
                None => nodes.for_each(|((point, normal), section)| {
                    cancel::ask(handle.as_ref());
                    (*point, *normal) = frame.nominal(&profile, section);
                }),
                Some((modifications, columns)) => {
                    let row = modifications.row(frame.side, *roll);
                    for (((point, normal), section), column) in nodes.zip(columns) {
                        cancel::ask(handle.as_ref());
                        (*point, *normal) = frame.modified(&profile, section, row.at(column));
                    }
                }
            }
        });
    }
}

/// Common values of all nodes of a flank.
struct Frame<'a> {
    flank: Flank<'a>,
    side: Side,
    /// s, σ, h.
    sign: f64,
    sense: f64,
    hand: f64,
    base_radius: f64,
    sin_base: f64,
    cos_base: f64,
    tan_base: f64,
    /// Angle of the tooth, rad counterclockwise.
    turn: f64,
}

/// One profile value in the section z = 0.
struct Profile {
    roll: f64,
    sin: f64,
    cos: f64,
    x: f64,
    y: f64,
}

/// One z.
struct Section {
    z: f64,
    sin: f64,
    cos: f64,
}

impl<'a> Frame<'a> {
    fn new(gear: &'a Gear, side: Side, tooth: u32) -> Self {
        let flank = Flank::new(gear, side);
        let (sin_base, cos_base) = gear.base_helix_angle().sin_cos();
        Frame {
            flank,
            side,
            sign: side.sign(),
            sense: flank.sense(),
            hand: gear.hand(),
            base_radius: gear.base_radius(),
            sin_base,
            cos_base,
            tan_base: sin_base / cos_base,
            turn: -gear.pitch_angle() * f64::from(tooth - 1),
        }
    }

    fn profile(&self, roll: f64) -> Profile {
        let (sin, cos) = (self.flank.tangent_angle(roll, 0.0) + self.turn).sin_cos();
        let along = self.sense * roll;
        let (x, y) = (-self.base_radius * sin - along * cos, self.base_radius * cos - along * sin);
        Profile { roll, sin, cos, x, y }
    }

    fn section(&self, z: f64) -> Section {
        let (sin, cos) = (self.flank.gear.turn_per_length() * z).sin_cos();
        Section { z, sin, cos }
    }

    #[inline]
    fn nominal(&self, at: &Profile, section: &Section) -> ([f64; 3], [f64; 3]) {
        let (sin, cos) = (section.sin, section.cos);
        let tangent = -self.sign * self.cos_base;
        (
            [at.x * cos - at.y * sin, at.x * sin + at.y * cos, section.z],
            [
                tangent * (at.cos * cos - at.sin * sin),
                tangent * (at.sin * cos + at.cos * sin),
                -self.sign * self.hand * self.sin_base,
            ],
        )
    }

    #[inline]
    fn modified(&self, at: &Profile, section: &Section, relief: Relief) -> ([f64; 3], [f64; 3]) {
        let (mut point, mut normal) = self.nominal(at, section);
        // µm to mm.
        let (height, by_roll, by_z) = (1e-3 * relief.value, 1e-3 * relief.by_roll, 1e-3 * relief.by_z);
        for (x, n) in point.iter_mut().zip(normal) {
            *x -= height * n;
        }
        let shrunk = (at.roll - self.sign * self.sense * height * self.cos_base) / self.base_radius;
        if shrunk > 0.0 {
            let (sin, cos) = (at.sin * section.cos + at.cos * section.sin, at.cos * section.cos - at.sin * section.sin);
            let lean = self.hand * self.tan_base;
            let along = shrunk * self.cos_base * self.cos_base * (by_z + self.sense * lean * by_roll);
            let tilted = [
                shrunk * normal[0] - by_roll * sin - along * lean * cos,
                shrunk * normal[1] + by_roll * cos - along * lean * sin,
                shrunk * normal[2] + along,
            ];
            let length = (tilted[0] * tilted[0] + tilted[1] * tilted[1] + tilted[2] * tilted[2]).sqrt();
            normal = tilted.map(|x| x / length);
        }
        (point, normal)
    }
}
