//! Designs and true coefficients for simulations of coverage.

use nalgebra::{DMatrix, SVD};

/// A measurement matrix with the eigenvectors of its columns of unit length.
pub struct Design {
    pub name: &'static str,
    pub x: Vec<Vec<f64>>,
    lengths: Vec<f64>,
    /// Singular values, ascending, and what belongs to them.
    pub directions: Vec<(f64, Vec<f64>)>,
}

/// True coefficients in the columns of unit length.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    /// All along the worst determined direction.
    Smallest,
    /// All along the best.
    Largest,
    /// The same share along each direction.
    Every,
}

impl Design {
    pub fn new(name: &'static str, x: Vec<Vec<f64>>) -> Self {
        let n = x[0].len();
        let lengths: Vec<f64> = (0..n).map(|j| x.iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt()).collect();
        let scaled = DMatrix::from_fn(x.len(), n, |i, j| x[i][j] / lengths[j]);
        let svd = SVD::new(scaled, false, true);
        let rows = svd.v_t.unwrap();
        let mut directions: Vec<(f64, Vec<f64>)> =
            (0..n).map(|i| (svd.singular_values[i], rows.row(i).iter().copied().collect())).collect();
        directions.sort_by(|p, q| p.0.total_cmp(&q.0));
        Design { name, x, lengths, directions }
    }

    /// Coefficients of the caller's columns with norm `r` in those of unit length.
    pub fn truth(&self, truth: Truth, r: f64) -> Vec<f64> {
        let n = self.lengths.len();
        let share = |i: usize| match truth {
            Truth::Smallest => f64::from(u8::from(i == 0)),
            Truth::Largest => f64::from(u8::from(i + 1 == n)),
            Truth::Every => 1.0 / (n as f64).sqrt(),
        };
        (0..n).map(|j| (0..n).map(|i| r * share(i) * self.directions[i].1[j]).sum::<f64>() / self.lengths[j]).collect()
    }
}

fn powers(places: impl Iterator<Item = f64>, degree: i32) -> Vec<Vec<f64>> {
    places.map(|x| (0..=degree).map(|p| x.powi(p)).collect()).collect()
}

/// Places from `low` to `high`.
fn even(count: u32, low: f64, high: f64) -> impl Iterator<Item = f64> + Clone {
    (0..count).map(move |i| low + (high - low) * f64::from(i) / f64::from(count - 1))
}

fn surface(u: (u32, f64, f64), v: (u32, f64, f64), degrees: [i32; 2]) -> Vec<Vec<f64>> {
    let places = even(u.0, u.1, u.2).flat_map(|x| even(v.0, v.1, v.2).map(move |y| (x, y)));
    let terms =
        |x: f64, y: f64| (0..=degrees[0]).flat_map(move |p| (0..=degrees[1]).map(move |q| x.powi(p) * y.powi(q)));
    places.map(|(x, y)| terms(x, y).collect()).collect()
}

/// Designs from well determined to hardly.
pub fn designs() -> Vec<Design> {
    let hilbert = (1..=24).map(|i| (1..=5).map(|j| 1.0 / f64::from(i + j)).collect()).collect();
    let twins = even(30, -1.0, 1.0).map(|x| vec![1.0, x, x + 1e-3 * (7.0 * x).sin()]).collect();
    vec![
        Design::new("cubic in mm, 30 to 40", powers(even(45, 30.0, 40.0), 3)),
        Design::new("Hilbert, 5 columns", hilbert),
        Design::new("surface 2 x 2 on [-1, 1]", surface((9, -1.0, 1.0), (5, -1.0, 1.0), [2, 2])),
        Design::new("two columns nearly equal", twins),
        Design::new("surface 2 x 2 in mm", surface((9, 30.0, 34.0), (5, 0.0, 20.0), [2, 2])),
        Design::new("sextic in mm, 30 to 34", powers(even(41, 30.0, 34.0), 6)),
        Design::new("line", powers(even(20, 0.0, 10.0), 1)),
        Design::new("quartic, 8 nodes", powers(even(8, 0.0, 1.0), 4)),
    ]
}
