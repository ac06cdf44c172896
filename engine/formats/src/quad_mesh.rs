//! Quadrilaterals over sampled surfaces, with or without the nodes of neighbouring patches joined.
//!
//! A mesh may have millions of nodes, so it is kept small: 64 bytes for a node with its normal and
//! the face that begins there. Joining happens in place.

use std::collections::HashMap;

use super::sampling::{self, no_place, no_tolerance};
use flankfit_geometry::{
    space::Vector,
    surface::{LocalGeometry, Surface},
};
use flankfit_numerics::{cancel::Asking, check::Faults};

/// Nodes and the faces between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadMesh {
    nodes: Vec<Vector>,
    /// Zero where there is none; empty if none were requested.
    normals: Vec<Vector>,
    faces: Vec<Face>,
}

/// Indices of nodes, counter-clockwise seen from where the normal points to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// A triangle repeats its third node.
    corners: [u32; 4],
}

impl Face {
    /// A face of three corners, in order around it.
    pub fn triangle([a, b, c]: [u32; 3]) -> Self {
        Face { corners: [a, b, c, c] }
    }

    /// Three or four of them.
    pub fn corners(&self) -> &[u32] {
        let [.., c, d] = self.corners;
        &self.corners[..if c == d { 3 } else { 4 }]
    }

    /// Four of them; a triangle repeats its third.
    pub fn four(&self) -> [u32; 4] {
        self.corners
    }

    /// Remainder of a face when some of its corners are the same node; `None` if it has no area any
    /// more.
    fn of(corners: [u32; 4]) -> Option<Face> {
        let [a, b, c, d] = corners;
        match [a == b, b == c, c == d, d == a] {
            [false, false, false, false] => (a != c && b != d).then_some(Face { corners }),
            [true, false, false, false] => Some(Face::triangle([a, c, d])),
            [false, true, false, false] => Some(Face::triangle([a, b, d])),
            [false, false, true, false] | [false, false, false, true] => Some(Face::triangle([a, b, c])),
            _ => None,
        }
    }
}

/// Samples side by side, before they are joined.
#[derive(Default)]
struct Apart {
    sizes: Vec<[usize; 2]>,
    nodes: Vec<Vector>,
    normals: Vec<Vector>,
}

impl Apart {
    /// The nodes of each surface where `intervals` parts of each of its patches meet.
    fn of_each(surfaces: &[&dyn Surface], intervals: [usize; 2], with_normals: bool) -> Result<Self, Faults> {
        let count = sampling::counted(surfaces, intervals)?;
        let mut apart = Apart::default();
        apart.nodes.reserve_exact(count);
        apart.normals.reserve_exact(if with_normals { count } else { 0 });
        for surface in surfaces {
            let [us, vs] = surface.breaks();
            let [us, vs] = [sampling::between(&us, intervals[0]), sampling::between(&vs, intervals[1])];
            sampling::check(&us, &vs)?;
            apart.sizes.push([us.len(), vs.len()]);
            for (u, v) in us.iter().flat_map(|u| vs.iter().map(move |v| (*u, *v))).asking(1000) {
                let LocalGeometry { point, normal, .. } = LocalGeometry::at(*surface, u, v);
                if !point.iter().all(|x| x.is_finite()) {
                    return Err(no_place([u, v]));
                }
                apart.nodes.push(point);
                if with_normals {
                    apart.normals.push(normal.unwrap_or_else(Vector::zeros));
                }
            }
        }
        Ok(apart)
    }

    /// The quadrilaterals of each sample, by the places of their nodes in the whole.
    fn quads(sizes: &[[usize; 2]]) -> impl Iterator<Item = [usize; 4]> {
        let mut first = 0;
        sizes.iter().flat_map(move |[m, n]| {
            let (begin, n) = (first, *n);
            first += m * n;
            let at = move |i: usize, j: usize| begin + i * n + j;
            (0..m - 1)
                .flat_map(move |i| (0..n - 1).map(move |j| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]))
        })
    }

    /// Joins near nodes and returns the new number of each node.
    fn join(&mut self, tolerance: f64) -> Vec<u32> {
        let mut number = leaders(&self.nodes, &self.sizes, tolerance);
        let with_normals = !self.normals.is_empty();
        let mut left = 0;
        // Nobody joins a later node and nodes only move forward, so that what is written here has
        // been read.
        for i in (0..number.len()).asking(50) {
            let leader = number[i] as usize;
            let to = if leader == i { left } else { number[leader] as usize };
            if with_normals {
                let before = if leader == i { Vector::zeros() } else { self.normals[to] };
                self.normals[to] = before + self.normals[i];
            }
            if leader == i {
                self.nodes[left] = self.nodes[i];
                left += 1;
            }
            number[i] = to as u32;
        }
        self.nodes.truncate(left);
        self.normals.truncate(left);
        // opposite normals leave nothing but rounding
        for normal in self.normals.iter_mut().asking(20) {
            *normal = if normal.norm() > 1e-10 { *normal / normal.norm() } else { Vector::zeros() };
        }
        number
    }
}

impl QuadMesh {
    /// Makes the mesh of surfaces of which each is sampled at so many intervals between its breaks,
    /// with nodes joined that lie on borders of patches no farther apart than `tolerance` (mm, ≥
    /// 0).
    ///
    /// A node joins the first one in the order of nodes that is near enough and has not itself
    /// joined another. A quadrilateral on a side without length so becomes a triangle; a face
    /// without area is left out. Neighbours must be sampled alike along their common border, else
    /// nodes of one lie between those of the other.
    pub fn of_surfaces(
        surfaces: &[&dyn Surface],
        intervals: [usize; 2],
        tolerance: f64,
        with_normals: bool,
    ) -> Result<Self, Faults> {
        check_tolerance(tolerance)?;
        Ok(Self::join(Apart::of_each(surfaces, intervals, with_normals)?, tolerance))
    }

    /// Bytes that such a mesh takes, at most.
    pub fn bytes(surfaces: &[&dyn Surface], intervals: [usize; 2], with_normals: bool) -> Result<usize, Faults> {
        let vectors = if with_normals { 2 } else { 1 };
        let node = vectors * size_of::<Vector>() + size_of::<Face>() + size_of::<u32>();
        Ok(node * sampling::counted(surfaces, intervals)?)
    }

    fn join(mut apart: Apart, tolerance: f64) -> Self {
        let number = apart.join(tolerance);
        let Apart { sizes, nodes, normals } = apart;
        let mut faces = Vec::with_capacity(number.len());
        faces.extend(Apart::quads(&sizes).asking(50).filter_map(|corners| Face::of(corners.map(|i| number[i]))));
        QuadMesh { nodes, normals, faces }
    }

    /// Places of the nodes, mm.
    pub fn nodes(&self) -> &[Vector] {
        &self.nodes
    }

    /// The unit normal at each node; where nodes were joined, that of the sum of theirs. `None`
    /// where there is none.
    pub fn normals(&self) -> impl Iterator<Item = Option<Vector>> {
        (0..self.nodes.len()).map(|i| self.normal(i))
    }

    /// The one at a node.
    pub fn normal(&self, node: usize) -> Option<Vector> {
        self.normals.get(node).copied().filter(|normal| normal.iter().any(|x| *x != 0.0))
    }

    /// Faces, their corners being indices of nodes.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }
}

fn check_tolerance(tolerance: f64) -> Result<(), Faults> {
    if tolerance >= 0.0 && tolerance.is_finite() { Ok(()) } else { Err(no_tolerance(tolerance)) }
}

/// Indices of the nodes on the border of their sample.
fn on_borders(sizes: &[[usize; 2]]) -> impl Iterator<Item = usize> {
    let mut first = 0;
    sizes.iter().flat_map(move |[m, n]| {
        let (begin, m, n) = (first, *m, *n);
        first += m * n;
        (0..m).flat_map(move |i| {
            // all of the first and the last row, the ends of the others
            let step = if i == 0 || i == m - 1 || n == 1 { 1 } else { n - 1 };
            (0..n).step_by(step).map(move |j| begin + i * n + j)
        })
    })
}

/// For each node the one it joins: itself, or an earlier one within `tolerance`.
fn leaders(nodes: &[Vector], sizes: &[[usize; 2]], tolerance: f64) -> Vec<u32> {
    // Cells no smaller than the tolerance: whatever is near enough is in a neighbouring one. The
    // floor keeps numbers of cells within what a double counts exactly; below it the cell is merely
    // larger than need be.
    let farthest = nodes.iter().flat_map(|p| p.iter()).fold(0.0, |most: f64, x| most.max(x.abs()));
    let size = tolerance.max(farthest * 1e-12).max(f64::MIN_POSITIVE);
    let cell = |p: &Vector| [p.x, p.y, p.z].map(|x| (x / size).floor() as i64);
    // The leaders in each cell, as a chain from the last one to the first.
    let mut cells: HashMap<[i64; 3], u32> = HashMap::new();
    let mut before: HashMap<u32, u32> = HashMap::new();
    let mut leaders: Vec<u32> = (0..nodes.len() as u32).collect();
    for i in on_borders(sizes).asking(500) {
        let [x, y, z] = cell(&nodes[i]);
        let around = (-1..=1).flat_map(|a| (-1..=1).flat_map(move |b| (-1..=1).map(move |c| [a, b, c])));
        let near = around
            .filter_map(|[a, b, c]| cells.get(&[x.saturating_add(a), y.saturating_add(b), z.saturating_add(c)]))
            .flat_map(|last| std::iter::successors(Some(*last), |k| before.get(k).copied()))
            .filter(|k| (nodes[*k as usize] - nodes[i]).norm() <= tolerance)
            .min();
        match near {
            Some(leader) => leaders[i] = leader,
            None => {
                if let Some(last) = cells.insert([x, y, z], i as u32) {
                    before.insert(i as u32, last);
                }
            }
        }
    }
    leaders
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_geometry::{BSplineBasis, space::Dimension, surface::BSplineSurface};

    fn patch(corners: [[f64; 3]; 4]) -> BSplineSurface {
        let line = || BSplineBasis::new(1, vec![0., 0., 1., 1.]).unwrap();
        let points = corners.map(|[x, y, z]| Vector::new(x, y, z)).to_vec();
        BSplineSurface::new([line(), line()], Dimension::Space, points, None).unwrap()
    }

    #[test]
    fn neighbours_share_their_border() {
        let left = patch([[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.]]);
        let right = patch([[1. + 1e-9, 0., 0.], [1., 1., 1e-9], [2., 0., 0.], [2., 1., 1.]]);
        let surfaces: [&dyn Surface; 2] = [&left, &right];
        let joined = |tolerance| QuadMesh::of_surfaces(&surfaces, [2, 3], tolerance, true);
        let mesh = joined(1e-6).unwrap();
        assert_eq!((mesh.nodes().len(), mesh.faces().len()), (20, 12));
        assert_eq!(mesh.faces()[6].corners(), [8, 12, 13, 9]);
        assert!(mesh.normals().all(|n| (n.unwrap().norm() - 1.0).abs() < 1e-15));
        // too tight, nothing is joined
        assert_eq!(joined(1e-12).unwrap().nodes().len(), 24);
        assert!(joined(f64::NAN).is_err() && joined(-1.0).is_err());
        let bare = QuadMesh::of_surfaces(&surfaces, [2, 3], 1e-6, false).unwrap();
        assert_eq!((bare.nodes(), bare.faces()), (mesh.nodes(), mesh.faces()));
        assert!(bare.normals().all(|normal| normal.is_none()));
        assert!(QuadMesh::bytes(&surfaces, [2, 3], true).unwrap() >= 36 * 24 + 18 * 12);
        // more than MOST_NODES are refused before any list of that length is made
        for intervals in [[10_000_000_000, 1], [1 << 62, 2], [usize::MAX; 2], [sampling::MOST_NODES, 1]] {
            let refused = QuadMesh::of_surfaces(&surfaces, intervals, 1e-6, false).unwrap_err();
            assert_eq!(refused.list()[0].path, "samples[0]", "{refused}");
        }
    }

    #[test]
    fn a_side_without_length_makes_triangles() {
        let wedge = patch([[0., 0., 1.], [1., 0., 0.], [0., 0., 1.], [0., 1., 0.]]);
        let mesh = QuadMesh::of_surfaces(&[&wedge], [3, 2], 0.0, true).unwrap();
        assert_eq!(mesh.nodes().len(), 1 + 4 * 2);
        let triangles = mesh.faces().iter().filter(|f| f.corners().len() == 3).count();
        assert_eq!((triangles, mesh.faces().len()), (3, 6));
        assert_eq!(mesh.faces()[0], Face::triangle([0, 3, 1]));
    }

    #[test]
    fn faces_that_vanish() {
        assert_eq!(Face::of([1, 2, 1, 3]), None);
        assert_eq!(Face::of([1, 1, 2, 2]), None);
        assert_eq!(Face::of([4, 4, 4, 4]), None);
        assert_eq!(Face::of([1, 2, 3, 1]), Some(Face::triangle([1, 2, 3])));
        assert_eq!(Face::of([1, 1, 2, 1]), None);
    }

    /// All 256 faces over four nodes against the rule: equal neighbours are one corner, and what is
    /// left must have an area.
    #[test]
    fn degenerate_faces_are_reduced_or_dropped() {
        for k in 0..256_u32 {
            let corners = [k % 4, k / 4 % 4, k / 16 % 4, k / 64];
            let mut left = corners.to_vec();
            left.dedup();
            if left.len() > 1 && left.first() == left.last() {
                left.pop();
            }
            let expected = match left[..] {
                [a, b, c, d] if a != c && b != d => Some(Face { corners: [a, b, c, d] }),
                [a, b, c] if a != c => Some(Face::triangle([a, b, c])),
                _ => None,
            };
            assert_eq!(Face::of(corners), expected, "{corners:?}");
        }
    }
}
