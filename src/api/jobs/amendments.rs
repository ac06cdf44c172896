//! Records of changes of the measurand (flank, tooth, axes, units) of stored nodes.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::{
    api::{
        json::{text::ShortText, writer::text_of},
        measurand::axes::{AxesBody, MeasurandBody},
    },
    jobs::{Measurand, RecordDraft, RecordKind},
};
use flankfit_engine::gear::Side;

/// Description of an iteration's nodes.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = KnownMeasurand)]
pub struct KnownMeasurandBody {
    pub flank: Option<Side>,
    /// The tooth that was measured, as on traces: its number from 1, or a name.
    #[schema(value_type = Option<String>, example = "1")]
    pub tooth: Option<ShortText>,
    pub axes: Option<AxesBody>,
    /// True if the units were confirmed although the values are implausible.
    pub accept_units: Option<bool>,
}

/// A change of the nodes' description: the values before and after it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MeasurandChange)]
pub struct MeasurandChangeBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub after: KnownMeasurandBody,
    pub before: KnownMeasurandBody,
}

impl MeasurandChangeBody {
    /// Reads a stored change; `None` if it is damaged, so that the record can still be shown.
    pub fn stored(document: &str) -> Option<Self> {
        serde_json::from_str(document).ok()
    }
}

impl KnownMeasurandBody {
    fn of(measurand: &Measurand) -> Result<Self, String> {
        AxesBody::of(measurand).map(|_| measurand.into())
    }
}

/// Axes that cannot be read are left out.
impl From<&Measurand> for KnownMeasurandBody {
    fn from(measurand: &Measurand) -> Self {
        KnownMeasurandBody {
            flank: measurand.flank,
            tooth: measurand.tooth.as_deref().and_then(ShortText::new),
            axes: measurand.axes.as_ref().and_then(|_| AxesBody::of(measurand).ok()),
            accept_units: measurand.accept_units.then_some(true),
        }
    }
}

/// Merges the given members with the earlier values of the others.
pub fn merged(given: MeasurandBody, before: &Measurand) -> Result<MeasurandBody, String> {
    let known = KnownMeasurandBody::of(before)?;
    Ok(MeasurandBody {
        flank: given.flank.or(known.flank),
        tooth: given.tooth.or(known.tooth),
        axes: match (given.axes, known.axes) {
            (Some(given), Some(known)) => Some(given.over(known)),
            (given, known) => given.or(known),
        },
    })
}

/// Returns the record of a change; its `method` says whether it was stored with the iteration
/// (`posted`) or later (`changed`).
pub fn record(before: &Measurand, after: &Measurand, method: &str, request: String) -> Result<RecordDraft, String> {
    let change = MeasurandChangeBody { after: KnownMeasurandBody::of(after)?, before: KnownMeasurandBody::of(before)? };
    let document: Arc<str> = text_of(&change).into();
    Ok(RecordDraft {
        kind: RecordKind::Measurand,
        method: method.to_owned(),
        request: request.into(),
        result: Arc::clone(&document),
        gear: None,
        class: None,
        measurand: Some(document),
    })
}
