//! Quadrilaterals over sampled surfaces, with or without the nodes of neighbouring patches joined.

use std::collections::HashMap;

use super::{fault::ExportFault, sampling::SurfaceSample};
use crate::geometry::space::Vector;
use crate::numerics::cancel::{self, Asking};

/// Nodes and the faces between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadMesh {
    nodes: Vec<Vector>,
    normals: Vec<Option<Vector>>,
    faces: Vec<Face>,
}

/// Indices of nodes, counter-clockwise seen from where the normal points to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    Quad([usize; 4]),
    Triangle([usize; 3]),
}

impl Face {
    pub fn corners(&self) -> &[usize] {
        match self {
            Face::Quad(corners) => corners,
            Face::Triangle(corners) => corners,
        }
    }

    /// What is left of a face when some of its corners are the same node; `None` if it has no area any more.
    fn of(corners: [usize; 4]) -> Option<Face> {
        let mut left = corners.to_vec();
        left.dedup();
        if left.len() > 1 && left.first() == left.last() {
            left.pop();
        }
        match left[..] {
            [a, b, c, d] if a != c && b != d => Some(Face::Quad([a, b, c, d])),
            [a, b, c] => Some(Face::Triangle([a, b, c])),
            _ => None,
        }
    }
}

impl QuadMesh {
    /// The quadrilaterals of all samples, as they are: neighbours keep nodes and normals of their own.
    pub fn of(samples: &[SurfaceSample]) -> Self {
        let mut mesh = QuadMesh::default();
        for sample in samples {
            cancel::checkpoint();
            let (first, [m, n]) = (mesh.nodes.len(), sample.size());
            mesh.nodes.extend(sample.nodes());
            mesh.normals.extend(sample.normals());
            let at = |i: usize, j: usize| first + i * n + j;
            for (i, j) in (0..m - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))).asking(50) {
                mesh.faces.push(Face::Quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
            }
        }
        mesh
    }

    /// The same with nodes joined that stand on borders of patches no farther apart than `tolerance` (mm, ≥ 0).
    ///
    /// A node joins the first one in the order of nodes that is near enough and has not itself joined another. A quadrilateral on a
    /// side without length so becomes a triangle; a face without area is left out. Neighbours must be sampled alike along their
    /// common border, else nodes of one stand between those of the other.
    pub fn joined(samples: &[SurfaceSample], tolerance: f64) -> Result<Self, ExportFault> {
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(ExportFault::Tolerance { tolerance });
        }
        let apart = Self::of(samples);
        let border: Vec<bool> = samples.iter().flat_map(on_border).collect();
        let leaders = leaders(&apart.nodes, &border, tolerance);
        let mut mesh = QuadMesh::default();
        let mut number = vec![0; leaders.len()];
        for (i, leader) in leaders.iter().enumerate().asking(50) {
            number[i] = if *leader == i {
                mesh.nodes.push(apart.nodes[i]);
                mesh.nodes.len() - 1
            } else {
                number[*leader]
            };
        }
        let mut sums = vec![Vector::zeros(); mesh.nodes.len()];
        for (i, normal) in apart.normals.iter().enumerate().asking(50) {
            sums[number[i]] += normal.unwrap_or_else(Vector::zeros);
        }
        // opposite normals leave nothing but rounding
        mesh.normals = sums.iter().map(|n| (n.norm() > 1e-10).then(|| n / n.norm())).collect();
        let renumbered = |face: &Face| match face {
            Face::Quad(corners) => Face::of(corners.map(|i| number[i])),
            Face::Triangle([a, b, c]) => Face::of([*a, *b, *c, *c].map(|i| number[i])),
        };
        mesh.faces = apart.faces.iter().filter_map(renumbered).collect();
        Ok(mesh)
    }

    pub fn nodes(&self) -> &[Vector] {
        &self.nodes
    }

    /// The unit normal at each node; where nodes were joined, that of the sum of theirs. `None` where there is none.
    pub fn normals(&self) -> &[Option<Vector>] {
        &self.normals
    }

    pub fn faces(&self) -> &[Face] {
        &self.faces
    }
}

/// For each node of a sample whether it stands on the border of the patch.
fn on_border(sample: &SurfaceSample) -> impl Iterator<Item = bool> {
    let [m, n] = sample.size();
    (0..m).flat_map(move |i| (0..n).map(move |j| i == 0 || i == m - 1 || j == 0 || j == n - 1))
}

/// For each node the one it joins: itself, or an earlier one within `tolerance`.
fn leaders(nodes: &[Vector], border: &[bool], tolerance: f64) -> Vec<usize> {
    // Cells no smaller than the tolerance: whatever is near enough is in a neighbouring one. The floor keeps numbers of cells
    // within what a double counts exactly; below it the cell is merely larger than need be.
    let farthest = nodes.iter().flat_map(|p| p.iter()).fold(0.0, |most: f64, x| most.max(x.abs()));
    let size = tolerance.max(farthest * 1e-12).max(f64::MIN_POSITIVE);
    let cell = |p: &Vector| [p.x, p.y, p.z].map(|x| (x / size).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut leaders: Vec<usize> = (0..nodes.len()).collect();
    for (i, node) in nodes.iter().enumerate().filter(|(i, _)| border[*i]).asking(500) {
        let [x, y, z] = cell(node);
        let around = (-1..=1).flat_map(|a| (-1..=1).flat_map(move |b| (-1..=1).map(move |c| [x + a, y + b, z + c])));
        let near = around
            .filter_map(|key| cells.get(&key))
            .flatten()
            .filter(|k| (nodes[**k] - node).norm() <= tolerance)
            .min();
        match near {
            Some(leader) => leaders[i] = *leader,
            None => cells.entry([x, y, z]).or_default().push(i),
        }
    }
    leaders
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{BSplineBasis, space::Dimension, surface::BSplineSurface};

    fn patch(corners: [[f64; 3]; 4]) -> BSplineSurface {
        let line = || BSplineBasis::new(1, vec![0., 0., 1., 1.]).unwrap();
        let points = corners.map(|[x, y, z]| Vector::new(x, y, z)).to_vec();
        BSplineSurface::new([line(), line()], Dimension::Space, points, None).unwrap()
    }

    #[test]
    fn neighbours_share_their_border() {
        let left = patch([[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.]]);
        let right = patch([[1. + 1e-9, 0., 0.], [1., 1., 1e-9], [2., 0., 0.], [2., 1., 1.]]);
        let samples = [left, right].map(|s| SurfaceSample::by_patches(&s, [2, 3]).unwrap());
        let apart = QuadMesh::of(&samples);
        assert_eq!((apart.nodes().len(), apart.faces().len()), (24, 12));
        let mesh = QuadMesh::joined(&samples, 1e-6).unwrap();
        assert_eq!((mesh.nodes().len(), mesh.faces().len()), (20, 12));
        assert_eq!(mesh.faces()[6], Face::Quad([8, 12, 13, 9]));
        assert!(mesh.normals().iter().all(|n| (n.unwrap().norm() - 1.0).abs() < 1e-15));
        // too tight, nothing is joined
        assert_eq!(QuadMesh::joined(&samples, 1e-12).unwrap().nodes().len(), 24);
        assert!(QuadMesh::joined(&samples, f64::NAN).is_err() && QuadMesh::joined(&samples, -1.0).is_err());
    }

    #[test]
    fn a_side_without_length_makes_triangles() {
        let wedge = patch([[0., 0., 1.], [1., 0., 0.], [0., 0., 1.], [0., 1., 0.]]);
        let mesh = QuadMesh::joined(&[SurfaceSample::by_patches(&wedge, [3, 2]).unwrap()], 0.0).unwrap();
        assert_eq!(mesh.nodes().len(), 1 + 4 * 2);
        let triangles = mesh.faces().iter().filter(|f| matches!(f, Face::Triangle(_))).count();
        assert_eq!((triangles, mesh.faces().len()), (3, 6));
        assert_eq!(mesh.faces()[0], Face::Triangle([0, 3, 1]));
    }

    #[test]
    fn faces_that_vanish() {
        assert_eq!(Face::of([1, 2, 1, 3]), None);
        assert_eq!(Face::of([1, 1, 2, 2]), None);
        assert_eq!(Face::of([4, 4, 4, 4]), None);
        assert_eq!(Face::of([1, 2, 3, 1]), Some(Face::Triangle([1, 2, 3])));
    }
}
