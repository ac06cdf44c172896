//! Surfaces of several patches on a grid of parameters, as a mesh of boundary curves divides them
//! (section 2.1 of the paper).

use super::{Surface, SurfaceJet, SurfaceShape, boundaries::merged, check};
use crate::space::{Dimension, Vector};
use flankfit_numerics::{cancel, check::Faults, words::counted};

/// Patches over the rectangles between given u and given v. Some may have three sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Patchwork {
    lines: [Vec<f64>; 2],
    /// v running fastest.
    patches: Vec<SurfaceShape>,
}

impl Patchwork {
    /// Patches between the lines `us` and `vs` (2 or more each, ascending), v running fastest, each
    /// over its own rectangle.
    pub fn new(us: Vec<f64>, vs: Vec<f64>, patches: Vec<SurfaceShape>) -> Result<Self, Faults> {
        let lines = [us, vs];
        for (axis, places) in lines.iter().enumerate() {
            check::at_least(axis, places.len(), 2)?;
            check::ascending(axis, places)?;
        }
        let [rows, columns] = lines.each_ref().map(|places| places.len() - 1);
        if patches.len() != rows * columns {
            let given = counted(patches.len(), "patch", "patches");
            return Err(Faults::one("patches", format_args!("{given} for {rows} × {columns} rectangles")));
        }
        let work = Patchwork { lines, patches };
        for (index, patch) in work.patches.iter().enumerate() {
            cancel::checkpoint();
            let (row, column) = (index / columns, index % columns);
            let at = format_args!("patches[{row}][{column}]");
            let (given, wanted) = (patch.domain(), work.rectangle(row, column));
            if given != wanted {
                let message = format_args!("patch {index} covers {given:?}, not its rectangle {wanted:?}");
                return Err(Faults::one(at, message));
            }
            let (given, wanted) = (patch.dimension().count(), work.patches[0].dimension().count());
            if given != wanted {
                let given = counted(given, "coordinate", "coordinates");
                let message = format_args!("patch {index} has values of {given}, the first one of {wanted}");
                return Err(Faults::one(at, message));
            }
            if matches!(patch, SurfaceShape::Patchwork(_)) {
                return Err(Faults::one(at, format_args!("patch {index} is a patchwork itself")));
            }
        }
        Ok(work)
    }

    /// The u and the v at which patches meet, ends included.
    pub fn lines(&self) -> &[Vec<f64>; 2] {
        &self.lines
    }

    /// The patches, v running fastest.
    pub fn patches(&self) -> &[SurfaceShape] {
        &self.patches
    }

    /// Patch i along u and j along v.
    pub fn patch(&self, i: usize, j: usize) -> &SurfaceShape {
        &self.patches[i * (self.lines[1].len() - 1) + j]
    }

    fn rectangle(&self, i: usize, j: usize) -> [[f64; 2]; 2] {
        let [us, vs] = &self.lines;
        [[us[i], us[i + 1]], [vs[j], vs[j + 1]]]
    }

    /// The patch that (u, v) lies in: the one above where it lies on a line.
    fn at(&self, u: f64, v: f64) -> &SurfaceShape {
        let find = |places: &[f64], x: f64| places[1..places.len() - 1].partition_point(|line| *line <= x);
        self.patch(find(&self.lines[0], u), find(&self.lines[1], v))
    }
}

impl Surface for Patchwork {
    fn dimension(&self) -> Dimension {
        self.patches[0].dimension()
    }

    fn domain(&self) -> [[f64; 2]; 2] {
        self.lines.each_ref().map(|places| [places[0], places[places.len() - 1]])
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        self.at(u, v).jet(u, v)
    }

    fn value(&self, u: f64, v: f64) -> Vector {
        self.at(u, v).value(u, v)
    }

    fn bends(&self, cuts: [&[f64]; 2]) -> Option<Vec<[f64; 3]>> {
        let place = |axis: usize, line: &f64| cuts[axis].iter().position(|cut| cut == line);
        let places =
            |axis: usize| self.lines[axis].iter().map(|line| place(axis, line)).collect::<Option<Vec<usize>>>();
        let (us, vs) = (places(0)?, places(1)?);
        let columns = cuts[1].len() - 1;
        let mut all = vec![[0.0; 3]; (cuts[0].len() - 1) * columns];
        for (i, u) in us.windows(2).enumerate() {
            for (j, v) in vs.windows(2).enumerate() {
                cancel::checkpoint();
                let own = self.patch(i, j).bends([&cuts[0][u[0]..=u[1]], &cuts[1][v[0]..=v[1]]])?;
                for (k, row) in own.chunks(v[1] - v[0]).enumerate() {
                    all[(u[0] + k) * columns + v[0]..][..row.len()].copy_from_slice(row);
                }
            }
        }
        Some(all)
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        let (mut us, mut vs) = (self.lines[0].clone(), self.lines[1].clone());
        for patch in &self.patches {
            let [more_us, more_vs] = patch.breaks();
            us.extend(more_us);
            vs.extend(more_vs);
        }
        [merged([us]), merged([vs])]
    }
}
