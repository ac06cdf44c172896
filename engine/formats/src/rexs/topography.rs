//! From the three lists of a flank to a grid.

use super::{super::topography::ascending, document::Value};
use flankfit_numerics::cancel;

/// Shape of the lists.
#[derive(Debug, PartialEq)]
pub(super) enum Shape {
    /// Diameters, coordinates, amounts row by row of diameters; whether the order of the amounts
    /// had to be assumed.
    Grid { diameter: Vec<f64>, z: Vec<f64>, amounts: Vec<f64>, assumed: bool },
    /// Diameter, coordinate and amount of each point.
    Scattered(Vec<[f64; 3]>),
}

/// `Err` with what was expected.
pub(super) fn shape(amounts: &Value, diameters: &[f64], coordinates: &[f64]) -> Result<Shape, &'static str> {
    const WANTED: &str = "one amount for each diameter and coordinate, or for each entry of lists of the same length";
    let (rows, columns) = (diameters.len(), coordinates.len());
    let grid = |value: &dyn Fn(usize, usize) -> f64, assumed: bool| {
        let (diameter, z, amounts) = ascending(diameters, coordinates, value)
            .ok_or("diameters and coordinates of which each stands there once")?;
        Ok(Shape::Grid { diameter, z, amounts, assumed })
    };
    match amounts {
        Value::Text(_) => Err("a list of amounts"),
        Value::Matrix { columns: width, values } => {
            if *width == columns && values.len() == rows * columns {
                // a square matrix has the diameters as its rows, like the others of this order
                grid(&|i, j| values[i * columns + j], rows == columns && rows > 1)
            } else if *width == rows && values.len() == rows * columns {
                grid(&|i, j| values[j * rows + i], false)
            } else {
                Err(WANTED)
            }
        }
        Value::Array(values) if values.len() == rows && rows == columns && rows > 1 => {
            let points: Vec<[f64; 3]> = (0..rows).map(|i| [diameters[i], coordinates[i], values[i]]).collect();
            Ok(folded(&points).unwrap_or(Shape::Scattered(points)))
        }
        Value::Array(values) if rows.checked_mul(columns) == Some(values.len()) => {
            grid(&|i, j| values[i * columns + j], rows > 1 && columns > 1)
        }
        Value::Array(_) => Err(WANTED),
    }
}

/// Points that fill a grid.
fn folded(points: &[[f64; 3]]) -> Option<Shape> {
    let distinct = |axis: usize| {
        let mut places: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        places.sort_by(cancel::comparing(f64::total_cmp));
        places.dedup();
        places
    };
    let (diameter, z) = (distinct(0), distinct(1));
    if diameter.len().checked_mul(z.len()) != Some(points.len()) {
        return None;
    }
    let mut amounts = vec![None; points.len()];
    for [d, at, amount] in points {
        let i = diameter.binary_search_by(|place| place.total_cmp(d)).ok()?;
        let j = z.binary_search_by(|place| place.total_cmp(at)).ok()?;
        amounts[i * z.len() + j] = Some(*amount);
    }
    let amounts = amounts.into_iter().collect::<Option<_>>()?;
    Some(Shape::Grid { diameter, z, amounts, assumed: false })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_of_every_kind() {
        let (d, z) = ([50.0, 51.0], [0.0, 5.0, 10.0]);
        let values: Vec<f64> = (0..6).map(f64::from).collect();
        let grid = |assumed| Shape::Grid { diameter: d.to_vec(), z: z.to_vec(), amounts: values.clone(), assumed };
        assert_eq!(shape(&Value::Array(values.clone()), &d, &z), Ok(grid(true)));
        assert_eq!(shape(&Value::Matrix { columns: 3, values: values.clone() }, &d, &z), Ok(grid(false)));
        let turned = vec![0.0, 3.0, 1.0, 4.0, 2.0, 5.0];
        assert_eq!(shape(&Value::Matrix { columns: 2, values: turned }, &d, &z), Ok(grid(false)));
        // points in any order that fill the grid
        let order = [5, 0, 3, 1, 4, 2];
        let (ds, zs): (Vec<_>, Vec<_>) = order.iter().map(|k| (d[k / 3], z[k % 3])).unzip();
        let amounts = order.iter().map(|k| values[*k]).collect();
        assert_eq!(shape(&Value::Array(amounts), &ds, &zs), Ok(grid(false)));
        let scattered = shape(&Value::Array(vec![1.0, 2.0, 3.0]), &[50.0, 51.0, 52.0], &[0.0, 1.0, 0.0]);
        assert!(matches!(scattered, Ok(Shape::Scattered(points)) if points.len() == 3));
        assert!(shape(&Value::Array(vec![1.0; 5]), &d, &z).is_err());
        assert!(shape(&Value::Array(vec![1.0; 6]), &[50.0, 50.0], &z).is_err());
        assert!(shape(&Value::Text("1".into()), &d, &z).is_err());
    }
}
