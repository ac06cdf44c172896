//! Which part of a measured flank takes part.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::faults::Faults;
use flankfit_engine::{
    gear::{
        Gear,
        deviation::{Border, Borders},
    },
    numerics::check,
};

/// Part of the flank that takes part.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = FlankBorders)]
pub struct BordersBody {
    /// At the root end, in percent of the measured profile's roll length. Default 0.
    pub root_percent: Option<f64>,
    /// At the tip end, in percent of the measured profile's roll length. Default 0.
    pub tip_percent: Option<f64>,
    /// At the end of small z, in percent of the measured width. Default 0.
    pub toe_percent: Option<f64>,
    /// At the end of great z, in percent of the measured width. Default 0.
    pub heel_percent: Option<f64>,
    /// Replaces the percentages at root and tip.
    #[schema(min_items = 2, max_items = 2)]
    pub diameter_range_mm: Option<[f64; 2]>,
    /// Replaces the percentages at toe and heel.
    #[schema(min_items = 2, max_items = 2)]
    pub z_range_mm: Option<[f64; 2]>,
}

impl BordersBody {
    /// Faults of the borders, by places in the request.
    pub fn placed(&self, faults: &check::Faults) -> Faults {
        let (range, percent) = (self.diameter_range_mm.is_some(), |share: Option<f64>| share.is_some());
        let profile = match percent(self.root_percent) {
            _ if range => "diameter_range_mm",
            true => "root_percent",
            false => "tip_percent",
        };
        let face = match percent(self.toe_percent) {
            _ if self.z_range_mm.is_some() => "z_range_mm",
            true => "toe_percent",
            false => "heel_percent",
        };
        Faults::placed(faults, |path| match path {
            "diameter_range_mm" => format!("/borders/{profile}"),
            "z_range_mm" => format!("/borders/{face}"),
            _ => "/borders".to_owned(),
        })
    }

    /// The borders.
    pub fn borders(&self, gear: &Gear) -> Result<Borders, Faults> {
        let percent = |share: Option<f64>| share.unwrap_or(0.0);
        let mut borders = Borders::trimmed(
            gear,
            percent(self.root_percent),
            percent(self.tip_percent),
            percent(self.toe_percent),
            percent(self.heel_percent),
        );
        let mut faults = Faults::default();
        if let Some(diameters) = self.diameter_range_mm {
            match diameters.map(|diameter| gear.roll_length(diameter)) {
                [Some(from), Some(to)] => borders.profile = Border::Range { from, to },
                _ => faults.push("/borders/diameter_range_mm", "a diameter lies below the base circle"),
            }
        }
        if let Some([from, to]) = self.z_range_mm {
            borders.face = Border::Range { from, to };
        }
        faults.into_result(borders)
    }
}
