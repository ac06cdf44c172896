//! Places at which a fit is asked for heights: wire parts to checked values.

use crate::api::{
    faults::Faults,
    fits::spec::{
        predict::{BandName, PlacesBody, PlacesGridBody, PlacesXBody, PredictBody},
        zeros::unsigned_zeros,
    },
    json::value::read_value,
};
use flankfit_engine::estimation::spec::{Kinds, Places, Predict};

/// The places and bands, when nothing is wrong with them; whether they suit the model is the
/// engine's to say.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<Predict> {
    let body: PredictBody = read_value(slice, "/predict", faults)?;
    let at = match body.at {
        PlacesBody { x: Some(PlacesXBody::Curve(x)), u: None, v: None, grid: None } => {
            Places::Curve(unsigned_zeros(&x))
        }
        PlacesBody { x: Some(PlacesXBody::Rows(rows)), u: None, v: None, grid: None } => {
            Places::Rows(rows.iter().map(|row| unsigned_zeros(row)).collect())
        }
        PlacesBody { x: None, u: Some(u), v: Some(v), grid: None } => {
            Places::Points { u: unsigned_zeros(&u), v: unsigned_zeros(&v) }
        }
        PlacesBody { x: None, u: None, v: None, grid: Some(PlacesGridBody { u, v }) } => {
            Places::Grid { u: unsigned_zeros(&u), v: unsigned_zeros(&v) }
        }
        _ => {
            let forms = "give either `x` (of a curve or a linear model), or `u` and `v`, or `grid` (of a surface)";
            faults.push("/predict/at", forms);
            return None;
        }
    };
    let kinds = match body.kinds {
        None => Kinds::default(),
        Some(names) => Kinds {
            confidence: names.contains(&BandName::Confidence),
            prediction: names.contains(&BandName::Prediction),
            simultaneous: names.contains(&BandName::Simultaneous),
        },
    };
    Some(Predict { at, level: body.level, kinds, slopes: body.slopes.unwrap_or(false) })
}
