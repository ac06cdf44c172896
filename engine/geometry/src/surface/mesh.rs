//! From a mesh of curves to a surface (section 2.1 of the paper): topology, nodes, network,
//! filling.
//!
//! One family of curves runs over v, each at one u; the other runs over u, each at one v.
//! Intersections of a surface with two families of parallel planes at right angles are such a mesh
//! of heights y(x). Where two curves cross they must agree. Every mesh is cut out of its curves
//! exactly, and filled with a patch of the kind asked for. The first or last curve of a family may
//! be missing on a mesh of points in space: the others then run together in one point, and the
//! patches there have three sides.

use super::{
    BezierSurface, CoonsPatch, Patchwork, SurfaceShape,
    boundaries::{Boundaries, CORNERS},
    check,
    continuity::Worst,
    coons::{Twists, corner_twists},
    gregory_fill::{deviation, gregory},
};
use crate::{
    curve::{BSplineCurve, Curve, CurveShape},
    space::{Dimension, Vector},
};
use flankfit_numerics::{
    cancel,
    check::{Fault, Faults},
    words::{Shown, counted},
};

/// Curves along the lines of a mesh, from two families of planes u = const and v = const.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields)
)]
pub struct CurveMesh {
    /// Positions of the curves over v, ascending.
    #[cfg_attr(feature = "contract", serde(rename = "u"), schema(min_items = 2))]
    pub us: Vec<f64>,
    /// Positions of the curves over u, ascending.
    #[cfg_attr(feature = "contract", serde(rename = "v"), schema(min_items = 2))]
    pub vs: Vec<f64>,
    /// For each u its curve over v. For points in space the first or the last may be `null`: the
    /// patches there are three-sided.
    #[cfg_attr(feature = "contract", serde(rename = "u_curves"))]
    pub over_v: Vec<Option<CurveShape>>,
    /// For each v its curve over u; `null` as above.
    #[cfg_attr(feature = "contract", serde(rename = "v_curves"))]
    pub over_u: Vec<Option<CurveShape>>,
}

/// Kind of patches that fill the meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    /// Bilinearly blended Coons patches: the curves are kept, the surface has edges along them.
    CoonsBilinear,
    /// Bicubically blended Coons patches with common twists at the nodes: C¹ where the curves are.
    CoonsBicubic,
    /// The same with twists of 0 (Ferguson): as smooth, with flat spots at the nodes.
    CoonsBicubicFlat,
    /// Gregory patches: C¹ across lines where the curves are, the borders cubics.
    Gregory,
    /// Bicubic Bézier patches with common twists at the nodes: C¹ where the curves are, the borders
    /// cubics.
    Bezier,
}

/// A filled mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    /// The patches, one for each mesh.
    pub patchwork: Patchwork,
    /// The largest gap at a crossing of two curves, and where.
    pub gap: Worst,
    /// How far borders of patches are from the curves at worst, and where: by cubics that curves
    /// are replaced by, and by corners half-way between curves that leave a gap.
    pub deviation: Worst,
}

/// Parameters of the curves, the curves, and the places along them.
type Family<'a> = (&'a [f64], &'a [Option<CurveShape>], &'a [f64]);

impl CurveMesh {
    /// Fills every mesh; curves that cross agree to `tolerance` in their coordinates.
    pub fn fill(&self, fill: Fill, tolerance: f64) -> Result<Filled, Faults> {
        check::tolerance(tolerance).map_err(of_patch(0, 0))?;
        self.check()?;
        let gap = self.crossings(tolerance)?;
        let [rows, columns] = [self.us.len() - 1, self.vs.len() - 1];
        let pieces = [cut(0, &self.over_v, &self.vs)?, cut(1, &self.over_u, &self.us)?];
        let mut meshes = Vec::with_capacity(rows * columns);
        for i in 0..rows {
            for j in 0..columns {
                meshes.push(self.boundaries(&pieces, i, j, tolerance)?);
            }
        }
        let nodes = match fill {
            Fill::CoonsBicubic | Fill::Bezier => Some(self.node_twists(&meshes)),
            _ => None,
        };
        let mut worst = Worst::default();
        let mut patches = Vec::with_capacity(meshes.len());
        for (k, mesh) in meshes.into_iter().enumerate() {
            cancel::checkpoint();
            let (i, j) = (k / columns, k % columns);
            let twists = || -> [[Vector; 2]; 2] {
                let at =
                    |a: usize, b: usize| nodes.as_ref().map_or(Vector::zeros(), |n| n[(i + a) * self.vs.len() + j + b]);
                [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]]
            };
            let none = [const { None }; 4];
            let (patch, off) = match fill {
                Fill::CoonsBilinear => {
                    let patch = CoonsPatch::bilinear(mesh);
                    let off = deviation(patch.boundaries(), &patch);
                    (SurfaceShape::Coons(Box::new(patch)), off)
                }
                Fill::CoonsBicubic | Fill::CoonsBicubicFlat => {
                    let patch =
                        CoonsPatch::bicubic(mesh, none, &Twists::Given(twists()), tolerance).map_err(of_patch(i, j))?;
                    let off = deviation(patch.boundaries(), &patch);
                    (SurfaceShape::Coons(Box::new(patch)), off)
                }
                Fill::Gregory => {
                    let (patch, off) = gregory(&mesh, &none, tolerance).map_err(of_patch(i, j))?;
                    (SurfaceShape::Gregory(Box::new(patch)), off)
                }
                Fill::Bezier => {
                    let patch = bicubic(&mesh, &twists()).map_err(of_patch(i, j))?;
                    let off = deviation(&mesh, &patch);
                    (SurfaceShape::Bezier(patch), off)
                }
            };
            worst.see(off.value, off.at);
            patches.push(patch);
        }
        let patchwork = Patchwork::new(self.us.clone(), self.vs.clone(), patches)?;
        Ok(Filled { patchwork, gap, deviation: worst })
    }

    fn families(&self) -> [Family<'_>; 2] {
        [(&self.us, &self.over_v, &self.vs), (&self.vs, &self.over_u, &self.us)]
    }

    /// Topology: places ascend, every place has its curve, every curve covers the mesh.
    fn check(&self) -> Result<(), Faults> {
        let mut dimension = None;
        let mut missing = Vec::new();
        // both axes first: the curves of one family run over the places of the other
        for (axis, places) in [&self.us, &self.vs].into_iter().enumerate() {
            check::at_least(axis, places.len(), 2)?;
            check::ascending(axis, places)?;
        }
        for (family, (places, curves, along)) in self.families().into_iter().enumerate() {
            if curves.len() != places.len() {
                let (given, wanted) =
                    (counted(curves.len(), "curve", "curves"), counted(places.len(), "place", "places"));
                return Err(Faults::one(FAMILIES[family], format_args!("{given} for {wanted}")));
            }
            for (index, curve) in curves.iter().enumerate() {
                cancel::checkpoint();
                let Some(curve) = curve else {
                    missing.push((family, index));
                    if index != 0 && index + 1 != curves.len() {
                        return Err(missing_curve(family, index));
                    }
                    continue;
                };
                let given = curve.dimension();
                let wanted = *dimension.get_or_insert(given);
                if given != wanted || given == Dimension::Plane {
                    let wanted = if wanted == Dimension::Plane { Dimension::Space } else { wanted };
                    let (given, wanted) = (counted(given.count(), "coordinate", "coordinates"), wanted.count());
                    let message = format_args!("the curve has values of {given}, where {wanted} are needed");
                    return Err(Faults::one(curve_at(family, index), message));
                }
                let ([low, high], [wanted_low, wanted_high]) = (curve.domain(), [along[0], along[along.len() - 1]]);
                if !(low <= wanted_low && wanted_high <= high) {
                    let [low, high, from, to] = [low, high, wanted_low, wanted_high].map(Shown);
                    let message = format_args!("the curve runs over [{low}, {high}], the mesh over [{from}, {to}]");
                    return Err(Faults::one(curve_at(family, index), message));
                }
            }
        }
        let dimension = dimension.unwrap_or(Dimension::Graph);
        match missing[..] {
            [] => Ok(()),
            [(family, index)] if dimension == Dimension::Graph => Err(missing_curve(family, index)),
            // both ends of one family may be points, but not ends of both
            [(family, index), .., (other, _)] if family != other => Err(missing_curve(family, index)),
            _ => Ok(()),
        }
    }

    /// Nodes: the largest gap between curves that cross.
    fn crossings(&self, tolerance: f64) -> Result<Worst, Faults> {
        let mut worst = Worst::default();
        for (i, (u, over_v)) in self.us.iter().zip(&self.over_v).enumerate() {
            for (j, (v, over_u)) in self.vs.iter().zip(&self.over_u).enumerate() {
                cancel::checkpoint();
                let (Some(one), Some(other)) = (over_v, over_u) else { continue };
                let gap = (one.value(*v) - other.value(*u)).norm();
                if !(gap <= tolerance) {
                    let [gap, tolerance] = [gap, tolerance].map(Shown);
                    return Err(Faults::one(
                        curve_at(0, i),
                        format_args!(
                            "curve {i} over v and curve {j} over u are {gap} apart where they cross, more than \
                             {tolerance}"
                        ),
                    ));
                }
                worst.see(gap, [*u, *v]);
            }
        }
        Ok(worst)
    }

    /// The four sides of mesh (i, j), or the three.
    fn boundaries(
        &self,
        [over_v, over_u]: &[Vec<Option<Vec<BSplineCurve>>>; 2],
        i: usize,
        j: usize,
        tolerance: f64,
    ) -> Result<Boundaries, Faults> {
        let piece = |curve: &Option<Vec<BSplineCurve>>, k: usize| {
            curve.as_ref().map(|pieces| CurveShape::BSpline(pieces[k].clone()))
        };
        let curves = [piece(&over_v[i], j), piece(&over_v[i + 1], j), piece(&over_u[j], i), piece(&over_u[j + 1], i)];
        let tolerance = tolerance.max(rounding(&curves));
        Boundaries::three_sided(curves, tolerance).map_err(of_patch(i, j))
    }

    /// At every node the mean of the twists that the bilinear fills around it have there.
    fn node_twists(&self, meshes: &[Boundaries]) -> Vec<Vector> {
        let (rows, columns) = (self.us.len(), self.vs.len());
        let mut sums = vec![(Vector::zeros(), 0.0); rows * columns];
        for (k, mesh) in meshes.iter().enumerate() {
            cancel::checkpoint();
            let (i, j) = (k / (columns - 1), k % (columns - 1));
            let Ok(twists) = corner_twists(mesh, &Twists::Adini) else { continue };
            for (a, b) in CORNERS {
                let (sum, count) = &mut sums[(i + a) * columns + j + b];
                *sum += twists[a][b];
                *count += 1.0;
            }
        }
        sums.into_iter().map(|(sum, count)| sum / count).collect()
    }
}

/// The curves at given u, which run over v, and those at given v.
const FAMILIES: [&str; 2] = ["mesh.u_curves", "mesh.v_curves"];

fn curve_at(family: usize, index: usize) -> String {
    format!("{}[{index}]", FAMILIES[family])
}

/// A curve that is missing and is neither the first nor the last of one family.
fn missing_curve(family: usize, index: usize) -> Faults {
    let message = "the curve is missing; only the first or last of one family may be missing, for points in space";
    Faults::one(curve_at(family, index), message)
}

/// Names the borders of patch (i, j) of a mesh in errors, by the curves that they are.
fn of_patch(i: usize, j: usize) -> impl Fn(Faults) -> Faults {
    move |faults| {
        faults.map(|Fault { path, message }| Fault {
            path: if path == "tolerance" { path } else { curve_at(0, i) },
            message: format!("patch ({i}, {j}): {message}"),
        })
    }
}

/// How far ends of pieces that were cut out may be off by rounding alone.
fn rounding(curves: &[Option<CurveShape>; 4]) -> f64 {
    let size = |curve: &CurveShape| curve.domain().map(|t| curve.value(t).norm()).into_iter().fold(0.0, f64::max);
    32.0 * f64::EPSILON * curves.iter().flatten().map(size).fold(0.0, f64::max)
}

/// Every curve of a family cut at `places`.
fn cut(family: usize, curves: &[Option<CurveShape>], places: &[f64]) -> Result<Vec<Option<Vec<BSplineCurve>>>, Faults> {
    let pieces = |(index, curve): (usize, &Option<CurveShape>)| {
        let Some(curve) = curve else { return Ok(None) };
        let refused = |faults: Faults| {
            faults.map(|Fault { message, .. }| Fault {
                path: curve_at(family, index),
                message: format!("the curve is not a B-spline: {message}"),
            })
        };
        let spline = curve.to_b_spline().map_err(refused)?;
        let pieces = places.windows(2).map(|pair| spline.restrict(pair[0], pair[1]).map_err(refused));
        pieces.collect::<Result<Vec<_>, _>>().map(Some)
    };
    curves.iter().enumerate().map(pieces).collect()
}

/// The bicubic patch with the corners, tangents and twists of the borders.
pub(super) fn bicubic(mesh: &Boundaries, twists: &[[Vector; 2]; 2]) -> Result<BezierSurface, Faults> {
    let domain = mesh.domain();
    let [third_u, third_v] = domain.map(|[low, high]| (high - low) / 3.0);
    let mut net = [Vector::zeros(); 16];
    for (i, j) in CORNERS {
        let sign = |end: usize| if end == 0 { 1.0 } else { -1.0 };
        let corner = mesh.corner(i, j);
        let (du, dv) = (mesh.tangent(2 + j, i) * (sign(i) * third_u), mesh.tangent(i, j) * (sign(j) * third_v));
        let twist = twists[i][j] * (sign(i) * sign(j) * third_u * third_v);
        let at = |a: usize, b: usize| 4 * a + b;
        net[at(3 * i, 3 * j)] = corner;
        net[at(1 + i, 3 * j)] = corner + du;
        net[at(3 * i, 1 + j)] = corner + dv;
        net[at(1 + i, 1 + j)] = corner + du + dv + twist;
    }
    BezierSurface::new([4, 4], domain, mesh.dimension(), net.to_vec(), None)
        .map_err(|_| check::twist_not_finite([0, 0]))
}
