//! Sections found: over every smooth rectangle of a surface, and joined.

use std::cell::Cell;

use super::{
    borders::{borders, sides_within},
    cells::Rectangle,
    chain::Pieces,
    fault::{LARGEST, SMALLEST, SectionFault},
    field::{Field, Kind},
    heights::Heights,
    join::{joined, without_twins},
    line::{Description, Line, SectionPoint, TooMany, Traced, line},
    march::pieces,
    near::distinct,
    plane::Plane,
    result::{Section, SectionCurve},
    spans::Patch,
};
use crate::{
    space::Vector,
    surface::{Surface, SurfaceShape},
};

/// Heights that count as 0, relative to the surface's extent.
const CONTACT: f64 = 1e-11;
/// The same for what rounding does to numbers as large as the surface's coordinates.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Ends nearer to each other than this part of the extent may be one place.
const NEAR: f64 = 1e-7;
/// Movement by rounding, relative to the extent, above which there is no section.
const FLAT: f64 = 1e-9;
/// Cells about places without slope that are looked at, at most.
const MOST_CELLS: usize = 50_000;

/// A surface made ready to be cut by planes.
///
/// ```
/// use flankfit_geometry::{
///     space::{Dimension, Vector},
///     surface::{BezierSurface, SurfaceShape, section::{Description, Plane, Sections}},
/// };
///
/// // z = u v over the square, cut half-way up: a branch of the hyperbola u v = 1/2.
/// let heights = [0.0, 0.0, 0.0, 1.0].map(|z| Vector::new(z, 0.0, 0.0)).to_vec();
/// let saddle = BezierSurface::new([2, 2], [[0.0, 1.0]; 2], Dimension::Graph, heights, None)?;
/// let saddle = SurfaceShape::Bezier(saddle);
/// let plane = Plane { normal: Vector::z(), offset: 0.5 };
/// let how = Description { tolerance: 1e-9, chords: false, most: 10_000 };
/// let found = Sections::of(&saddle).by(&plane, how)?;
/// let [curve] = &found.curves[..] else { panic!("one branch") };
/// for place in &curve.points {
///     assert!((place.point.x * place.point.y - 0.5).abs() < 1e-14);
/// }
/// assert!(!curve.closed && curve.error <= 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Sections<'a> {
    patches: Vec<Patch<'a>>,
    /// The largest width of a coordinate, and the largest coordinate.
    extent: [f64; 2],
}

impl<'a> Sections<'a> {
    /// Sections of a surface, or of all patches of a patchwork.
    pub fn of(surface: &'a SurfaceShape) -> Self {
        Self::on(Patch::of_shape(surface))
    }

    /// Returns sections of surfaces of any kind that make one: their lines are joined where they go
    /// on. Bounds of their heights are sampled.
    pub fn of_surfaces(surfaces: &[&'a dyn Surface]) -> Self {
        Self::on(surfaces.iter().map(|surface| Patch::plain(*surface)).collect())
    }

    fn on(patches: Vec<Patch<'a>>) -> Self {
        let bounds = patches.iter().map(Patch::bounds);
        let [low, high] =
            bounds.reduce(|[low, high], [a, b]| [low.inf(&a), high.sup(&b)]).unwrap_or([Vector::zeros(); 2]);
        Sections { patches, extent: [(high - low).amax(), high.amax().max(low.amax())] }
    }

    fn check(&self) -> Result<(), SectionFault> {
        let widths = self.patches.iter().flat_map(|patch| patch.surface.domain()).map(|[low, high]| high - low);
        let [size, largest] = self.extent;
        if !widths.chain([size]).all(|width| (SMALLEST..=LARGEST).contains(&width)) || !(largest <= LARGEST) {
            return Err(SectionFault::OutOfRange);
        }
        self.patches.iter().try_for_each(Patch::check)
    }

    /// The section by a plane.
    pub fn by(&self, plane: &Plane, how: Description) -> Result<Section, SectionFault> {
        let [size, largest] = self.extent;
        let rounding = ROUNDING * (largest + plane.offset.abs());
        let contact = (CONTACT * size).max(rounding);
        self.check()?;
        let mut found = Section::default();
        let (mut lines, mut left) = (Vec::new(), how.most);
        for (index, patch) in self.patches.iter().enumerate() {
            let flat = patch.each((index, plane, contact, how.tolerance.max(FLAT * size)), &mut |field, heights| {
                let own = smooth(field, heights, [contact, rounding]);
                found.take(field, own, (size, how), (&mut lines, &mut left))
            })?;
            found.coincident |= flat;
        }
        let near = (NEAR * size).max(ROUNDING * largest);
        for points in [&mut found.branch_points, &mut found.contacts, &mut found.unresolved] {
            distinct(points, near);
        }
        found.curves = joined(without_twins(lines, near), &found.branch_points, near)
            .into_iter()
            // a loop that is one place
            .filter(|line| !(line.closed && line.points.last().is_none_or(|last| last.length <= near)))
            .map(|Line { points, closed, touching, error }| SectionCurve {
                points: ascending(points),
                closed,
                tangential: touching,
                error,
            })
            .collect();
        Ok(found)
    }
}

/// Without places that rounding of the length has made one with the place before; the end stays.
fn ascending(points: Vec<SectionPoint>) -> Vec<SectionPoint> {
    let mut kept: Vec<SectionPoint> = Vec::with_capacity(points.len());
    for point in points {
        while kept.len() > 1 && kept.last().is_some_and(|last| last.length >= point.length) {
            kept.pop();
        }
        kept.push(point);
    }
    kept
}

/// Parts of the section in a smooth rectangle.
fn smooth(field: &Field<'_>, heights: Heights, [contact, rounding]: [f64; 2]) -> Pieces {
    let left = Cell::new(MOST_CELLS);
    let rectangle = Rectangle { field, range: field.smooth, heights, depth: 0, contact, rounding, left: &left };
    let mut all = Pieces::default();
    let found = rectangle.search();
    let sides = sides_within(&rectangle);
    pieces(&rectangle, found, &sides, &mut all);
    borders(&rectangle, &sides, &mut all);
    all
}

impl Section {
    fn take(
        &mut self,
        field: &Field<'_>,
        own: Pieces,
        (size, how): (f64, Description),
        (lines, left): (&mut Vec<Line>, &mut usize),
    ) -> Result<(), SectionFault> {
        let space = |at: &[f64; 2]| field.at(*at).jet.value;
        self.branch_points.extend(own.branches.iter().map(space));
        self.contacts.extend(own.contacts.iter().map(space));
        self.unresolved.extend(own.unresolved.iter().map(space));
        self.coincident |= own.coincident;
        for chain in &own.chains {
            let rest = Description { most: *left, ..how };
            match line(field, chain, size, rest).map_err(|TooMany| SectionFault::TooManyPoints { most: how.most })? {
                Traced::Line(line) => {
                    *left = left.saturating_sub(line.points.len());
                    lines.push(line);
                }
                // a line at a pole is one place
                Traced::OnePlace => {
                    let touching = chain.places.iter().find(|(_, kind)| *kind == Kind::Touching);
                    self.contacts.extend(touching.map(|(at, _)| space(at)));
                }
                Traced::Unclear => self.unresolved.push(space(&chain.places[chain.places.len() / 2].0)),
            }
        }
        Ok(())
    }
}
