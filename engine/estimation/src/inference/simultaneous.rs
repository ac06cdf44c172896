//! Factors of bands that hold over a whole curve or surface at once.
//!
//! A band `value(x) ± c · se(x)` holds everywhere with the probability that `|γ(x)ᵀT| ≤ c` for
//! every x, γ(x) being unit vectors that run along a path (a curve) or over a sheet (a surface) of
//! the sphere, and T a vector of n normal errors over σ̂. Scheffé's c allows for every unit vector
//! there is; the volume of a tube about the path or sheet allows for those alone that occur:
//!
//! ```text
//! 2 [P(t_ν > c) + ℓ/(2π) (1 + c²/ν)^(−ν/2) + a (2π)^(−3/2) c m (1 + c²/ν)^(−(ν+1)/2)] = α
//! ```
//!
//! with ℓ the length of the path and a = 0 (Naiman, Annals of Statistics 14, 1986: a bound), or ℓ
//! half the length of the sheet's edge and a its area (Sun and Loader, Annals of Statistics 22,
//! 1994); `m = √(2/ν) Γ((ν+1)/2) / Γ(ν/2)`.

use std::f64::consts::PI;

use super::noise::Noise;
use flankfit_numerics::{
    distribution::{chi_squared, fisher},
    root::boundary,
};

/// Method for the factor of a simultaneous band: Scheffé's, or, where that is narrower, the
/// volume of a tube (Naiman; Sun and Loader; curves and surfaces) or Student's t at the level
/// divided by the number of rows (Bonferroni; rows of a measurement matrix).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum SimultaneousMethod {
    /// All unit vectors.
    Scheffe,
    /// A tube about those that occur.
    Tube,
    /// Every vector by itself.
    Bonferroni,
}

impl SimultaneousMethod {}

/// Size of the path or sheet that the unit vectors run over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    /// Length of the path, or half that of the sheet's edge.
    pub length: f64,
    /// Area of the sheet; 0 of a path.
    pub area: f64,
}

/// The unit vectors that occur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Among {
    /// Unit vectors of a curve or a surface.
    Tube(Tube),
    /// So many, each by itself.
    Each(usize),
}

/// Sun and Loader's formula for sheets holds from this factor on.
const LEAST_OF_SHEETS: f64 = 2.5;

/// √(n F): every linear form of n coefficients at once.
pub fn scheffe(n: usize, noise: &Noise) -> f64 {
    let (n, freedom) = (n as f64, noise.student.freedom());
    if freedom == f64::INFINITY {
        return chi_squared::upper_quantile(noise.miss, n).sqrt();
    }
    (n * fisher::upper_quantile(noise.miss, n, freedom)).sqrt()
}

/// The factor for a tube.
pub fn tube_factor(tube: &Tube, noise: &Noise) -> f64 {
    let student = &noise.student;
    let miss = |c: f64| {
        let sheet = tube.area * (2.0 * PI).powf(-1.5) * c * student.mean_ratio() * student.power(c, 1.0);
        2.0 * (student.upper_tail(c) + tube.length / (2.0 * PI) * student.power(c, 0.0) + sheet)
    };
    // falls from c = 1 on at the latest
    let mut high = noise.quantile().max(2.0);
    while miss(high) > noise.miss && high < 1e9 {
        high *= 2.0;
    }
    boundary([noise.quantile().min(high), high], 1e-12, |c| miss(c) > noise.miss)[1]
}

/// Student's factor at the level at which `count` intervals together miss no more often than one
/// (Bonferroni).
pub fn bonferroni(count: usize, noise: &Noise) -> f64 {
    noise.student.upper_quantile(0.5 * noise.miss / count.max(1) as f64)
}

/// The smaller of Scheffé's factor and the one for the vectors that occur.
pub fn simultaneous_factor(n: usize, among: Option<&Among>, noise: &Noise) -> (f64, SimultaneousMethod) {
    let every = scheffe(n, noise);
    let own = among.and_then(|among| match among {
        Among::Tube(tube) => {
            let c = tube_factor(tube, noise);
            (tube.area == 0.0 || c >= LEAST_OF_SHEETS).then_some((c, SimultaneousMethod::Tube))
        }
        Among::Each(count) => Some((bonferroni(*count, noise), SimultaneousMethod::Bonferroni)),
    });
    own.filter(|(c, _)| *c < every).unwrap_or((every, SimultaneousMethod::Scheffe))
}

/// Length of a path of unit vectors through `vectors`, chord by chord.
pub fn path_length(vectors: &[Vec<f64>]) -> f64 {
    vectors.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum()
}

/// Area of a sheet of unit vectors and half the length of its edge, from `rows` by `columns`
/// vectors, columns running fastest.
pub fn sheet(vectors: &[Vec<f64>], rows: usize, columns: usize) -> Tube {
    let at = |i: usize, j: usize| &vectors[i * columns + j];
    let mut area = 0.0;
    for i in 1..rows {
        for j in 1..columns {
            let corners = [at(i - 1, j - 1), at(i - 1, j), at(i, j - 1), at(i, j)];
            let (mut uu, mut vv, mut uv) = (0.0, 0.0, 0.0);
            for k in 0..corners[0].len() {
                let [a, b, c, d] = corners.map(|corner| corner[k]);
                let (u, v) = (0.5 * (c + d - a - b), 0.5 * (b + d - a - c));
                uu += u * u;
                vv += v * v;
                uv += u * v;
            }
            area += (uu * vv - uv * uv).max(0.0).sqrt();
        }
    }
    let along_rows = |j: usize| (1..rows).map(move |i| distance(at(i - 1, j), at(i, j))).sum::<f64>();
    let along_columns = |i: usize| (1..columns).map(move |j| distance(at(i, j - 1), at(i, j))).sum::<f64>();
    let edge = along_rows(0) + along_rows(columns - 1) + along_columns(0) + along_columns(rows - 1);
    Tube { length: 0.5 * edge, area }
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_circle_is_scheffe_of_two() {
        // all unit vectors of the plane up to sign: half a circle
        let noise = Noise::estimated(1.0, 20.0, 0.95);
        let circle = tube_factor(&Tube { length: PI, area: 0.0 }, &noise);
        // Naiman's bound counts the ends, which a closed path has not
        assert!(circle >= scheffe(2, &noise) && circle < scheffe(2, &noise) + 0.25, "{circle}");
    }

    #[test]
    fn no_path_is_student() {
        for noise in [Noise::estimated(1.0, 7.0, 0.9), Noise::known(1.0, 0.99)] {
            let point = tube_factor(&Tube { length: 0.0, area: 0.0 }, &noise);
            assert!((point - noise.quantile()).abs() < 1e-9);
            assert!((scheffe(1, &noise) - noise.quantile()).abs() < 1e-8);
        }
    }

    #[test]
    fn lengths_and_areas_of_the_sphere() {
        let steps = 200;
        let circle: Vec<Vec<f64>> =
            (0..=steps).map(|i| f64::from(i) * PI / 200.0).map(|a| vec![a.cos(), a.sin()]).collect();
        assert!((path_length(&circle) - PI).abs() < 1e-3);
        // an eighth of the sphere, as latitudes and longitudes
        let octant: Vec<Vec<f64>> = (0..=steps)
            .flat_map(|i| (0..=steps).map(move |j| [i, j].map(|k| f64::from(k) * 0.5 * PI / 200.0)))
            .map(|[a, b]| vec![a.cos() * b.cos(), a.cos() * b.sin(), a.sin()])
            .collect();
        let tube = sheet(&octant, 201, 201);
        assert!((tube.area - 0.5 * PI).abs() < 1e-3, "{tube:?}");
        assert!((tube.length - 0.75 * PI).abs() < 1e-3, "{tube:?}");
    }
}
