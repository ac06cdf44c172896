//! Hexahedra with named sets of faces.

use flankfit_geometry::space::Vector;
use flankfit_numerics::cancel::Asking;

/// Places of the 20 nodes of a hexahedron in its own coordinates: corners of the lower face
/// counterclockwise, of the upper one, middles of lower, upper and upright edges.
const PLACES: [[f64; 3]; 20] = [
    [-1., -1., -1.],
    [1., -1., -1.],
    [1., 1., -1.],
    [-1., 1., -1.],
    [-1., -1., 1.],
    [1., -1., 1.],
    [1., 1., 1.],
    [-1., 1., 1.],
    [0., -1., -1.],
    [1., 0., -1.],
    [0., 1., -1.],
    [-1., 0., -1.],
    [0., -1., 1.],
    [1., 0., 1.],
    [0., 1., 1.],
    [-1., 0., 1.],
    [-1., -1., 0.],
    [1., -1., 0.],
    [1., 1., 0.],
    [-1., 1., 0.],
];

/// The nodes of each face, corners first, in the order that points outwards: lower, upper, and from
/// the edge between the first two corners on around the sides.
pub const FACES: [[usize; 8]; 6] = [
    [0, 3, 2, 1, 11, 10, 9, 8],
    [4, 5, 6, 7, 12, 13, 14, 15],
    [0, 1, 5, 4, 8, 17, 12, 16],
    [1, 2, 6, 5, 9, 18, 13, 17],
    [2, 3, 7, 6, 10, 19, 14, 18],
    [3, 0, 4, 7, 11, 16, 15, 19],
];

/// A face of an element: the element and which of its [`FACES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HexFace {
    /// Index of the element.
    pub element: u32,
    /// Index of the face.
    pub face: u8,
}

/// Faces with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceSet {
    /// Capital letters, digits and underscores.
    pub name: String,
    /// In the order of the elements.
    pub faces: Vec<HexFace>,
}

/// Nodes and hexahedra of 8 or 20 nodes each.
#[derive(Clone, Debug, PartialEq)]
pub struct HexMesh {
    pub(super) nodes: Vec<Vector>,
    pub(super) elements: Vec<u32>,
    pub(super) quadratic: bool,
    pub(super) sets: Vec<FaceSet>,
}

impl HexMesh {
    /// Places of the nodes, mm.
    pub fn nodes(&self) -> &[Vector] {
        &self.nodes
    }

    /// Whether elements have 20 nodes, not 8.
    pub fn is_quadratic(&self) -> bool {
        self.quadratic
    }

    /// Number of elements.
    pub fn count(&self) -> usize {
        self.elements.len() / self.width()
    }

    fn width(&self) -> usize {
        if self.quadratic { 20 } else { 8 }
    }

    /// Nodes of an element: corners of its lower face counterclockwise seen from the upper one,
    /// those of the upper one; where there are 20, the middles of lower, upper and upright edges.
    pub fn element(&self, index: usize) -> &[u32] {
        &self.elements[index * self.width()..(index + 1) * self.width()]
    }

    /// Named sets of faces.
    pub fn sets(&self) -> &[FaceSet] {
        &self.sets
    }

    /// Nodes of a face, corners first, in the order that points outwards.
    pub fn face(&self, face: HexFace) -> impl Iterator<Item = u32> + '_ {
        let count = if self.quadratic { 8 } else { 4 };
        let element = self.element(face.element as usize);
        FACES[usize::from(face.face)][..count].iter().map(|k| element[*k])
    }

    /// The nodes of a set, ascending.
    pub fn nodes_of(&self, set: &FaceSet) -> Vec<u32> {
        let mut nodes: Vec<u32> = set.faces.iter().asking(50).flat_map(|face| self.face(*face)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// The determinant of the map from an element's own coordinates, each from −1 to 1, to places.
    pub fn jacobian(&self, element: usize, at: [f64; 3]) -> f64 {
        let mut columns = [Vector::zeros(); 3];
        for (node, place) in self.element(element).iter().zip(&PLACES) {
            let slopes = if self.quadratic { serendipity(place, at) } else { trilinear(place, at) };
            let point = self.nodes[*node as usize];
            columns.iter_mut().zip(slopes).for_each(|(column, slope)| *column += point * slope);
        }
        columns[0].cross(&columns[1]).dot(&columns[2])
    }

    /// The least determinant at corners, middles of edges and faces, and centres of all elements.
    pub fn least_jacobian(&self) -> f64 {
        let steps = if self.quadratic { 3 } else { 2 };
        let place = |k: usize| if steps == 3 { k as f64 - 1.0 } else { 2.0 * k as f64 - 1.0 };
        let at = |k: usize| [place(k % steps), place(k / steps % steps), place(k / (steps * steps))];
        let own =
            |element: usize| (0..steps.pow(3)).map(move |k| self.jacobian(element, at(k))).fold(f64::MAX, f64::min);
        (0..self.count()).asking(2000).map(own).fold(f64::MAX, f64::min)
    }

    /// Its volume, mm³: by Gauss' rule, which is exact for these elements.
    pub fn volume(&self) -> f64 {
        let (places, weights) = ([-(0.6_f64.sqrt()), 0.0, 0.6_f64.sqrt()], [5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0]);
        let of = |element: usize| -> f64 {
            let each = (0..27).map(|k| [k % 3, k / 3 % 3, k / 9]);
            each.map(|k| self.jacobian(element, k.map(|k| places[k])) * k.iter().map(|k| weights[*k]).product::<f64>())
                .sum()
        };
        (0..self.count()).asking(2000).map(of).sum()
    }
}

/// Slopes of a trilinear function that is 1 at `node`.
fn trilinear(node: &[f64; 3], at: [f64; 3]) -> [f64; 3] {
    let factor = |k: usize| 1.0 + node[k] * at[k];
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        0.125 * node[k] * factor(i) * factor(j)
    })
}

/// Slopes of a serendipity function that is 1 at `node`.
fn serendipity(node: &[f64; 3], at: [f64; 3]) -> [f64; 3] {
    let factor = |k: usize| 1.0 + node[k] * at[k];
    match node.iter().position(|x| *x == 0.0) {
        None => {
            let sum = (0..3).map(|k| node[k] * at[k]).sum::<f64>() - 2.0;
            std::array::from_fn(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                0.125 * node[k] * factor(i) * factor(j) * (sum + factor(k))
            })
        }
        Some(middle) => std::array::from_fn(|k| {
            let bubble = 1.0 - at[middle] * at[middle];
            let others = |k: usize| (0..3).filter(move |i| *i != middle && *i != k);
            if k == middle {
                0.25 * -2.0 * at[k] * others(k).map(factor).product::<f64>()
            } else {
                0.25 * bubble * node[k] * others(k).map(factor).product::<f64>()
            }
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit cube of 8 and of 20 nodes: determinant 1/8 everywhere, volume 1, faces that point
    /// outwards.
    #[test]
    fn a_cube() {
        for quadratic in [false, true] {
            let count = if quadratic { 20 } else { 8 };
            let nodes = PLACES[..count].iter().map(|p| Vector::from(p.map(|x| 0.5 * x))).collect();
            let cube = HexMesh { nodes, elements: (0..count as u32).collect(), quadratic, sets: Vec::new() };
            for at in [[0.0; 3], [0.3, -0.7, 0.9], [1.0, 1.0, -1.0]] {
                assert!((cube.jacobian(0, at) - 0.125).abs() < 1e-15);
            }
            assert!((cube.volume() - 1.0).abs() < 1e-14 && (cube.least_jacobian() - 0.125).abs() < 1e-15);
            for face in 0..6 {
                let corners: Vec<Vector> =
                    cube.face(HexFace { element: 0, face }).map(|node| cube.nodes[node as usize]).collect();
                let normal = (corners[1] - corners[0]).cross(&(corners[3] - corners[0]));
                assert!((normal.dot(&corners[0]) - 0.5).abs() < 1e-15, "{face}");
                for k in 4..corners.len() {
                    let (a, b) = (corners[k - 4], corners[(k - 3) % 4]);
                    assert_eq!(corners[k], (a + b) * 0.5, "{face}");
                }
            }
        }
    }
}
