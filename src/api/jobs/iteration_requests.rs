//! Requests of iterations: nodes with details of the measurement, further fits, and decisions on
//! the gear.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{
    api::{
        fits::spec::{nodes::NodesBody, request::FitSpecBody},
        gears::correction::applied::AppliedRequestBody,
        json::{
            request::request,
            text::{LongText, Moment, ShortText},
        },
        measurand::axes::{AxesBody, MeasurandBody},
        tables::mapping::MappingBody,
    },
    jobs::{Decision, MeasurementDetails},
};
use flankfit_engine::gear::Side;

/// A fit request with details of the measurement.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = IterationRequest)]
pub struct IterationRequest {
    pub nodes: NodesBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurement: Measurement,
}

/// An iteration request as a form (`multipart/form-data`).
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct IterationForm {
    /// The iteration request without `nodes`, as JSON.
    pub spec: IterationFormSpec,
    /// A table of nodes in any form accepted by `POST /v1/nodes/read`, such as CSV with a header
    /// `u,v,z[,weight]` or `x,y[,weight]`; an empty height is a missing node. Its flank, tooth and
    /// axes are used if `spec` has none.
    #[schema(value_type = String, format = Binary)]
    pub nodes: Vec<u8>,
    /// Mapping of the table.
    pub mapping: Option<MappingBody>,
}

/// An iteration request without nodes.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct IterationFormSpec {
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurement: Measurement,
}

request! {
    /// Details of a measurement.
    #[derive(Default)]
    pub struct Measurement as MeasurementMembers, read whole {
        flatten measurand: MeasurandBody,
        /// Confirms units that seem implausible (warning `implausible_unit`).
        optional accept_units: bool,
        flatten details: MeasurementDetailsBody,
        /// Changes that were entered on the machine before this measurement, as in `POST
        /// …/correction/applied`. They belong to the newest correction of an earlier iteration of
        /// the flank.
        optional applied: AppliedRequestBody,
    }
}

request! {
    /// Details of the measurement of a stream. All of them are optional, and so is the body.
    #[derive(Default, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[schema(as = StreamFinish)]
    pub struct MeasurementDetailsBody as MeasurementDetailsMembers, read whole {
        /// RFC 3339, any offset; returned in UTC.
        #[schema(value_type = Option<String>, format = DateTime, example = "2026-11-21T08:30:00Z")]
        optional measured_at: Moment,
        /// Measuring instrument.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 200, example = "P40")]
        optional instrument: ShortText,
        /// Operator who measured the nodes.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
        optional operator: ShortText,
        /// Note on the measurement; may have line breaks.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
        optional note: LongText,
    }
}

impl From<MeasurementDetailsBody> for MeasurementDetails {
    fn from(body: MeasurementDetailsBody) -> Self {
        MeasurementDetails {
            measured_at: body.measured_at.map(|moment| moment.0),
            instrument: body.instrument.map(String::from),
            operator: body.operator.map(String::from),
            note: body.note.map(String::from),
        }
    }
}

/// A fit request without nodes: the stored ones are fitted again.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = RefitRequest)]
pub struct RefitRequest {
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
    #[serde(flatten)]
    #[schema(inline)]
    pub why: Why,
}

/// A fit request without nodes: the stored nodes are fitted.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = PreviewRequest)]
pub struct PreviewRequest {
    #[serde(flatten)]
    #[schema(inline)]
    pub spec: FitSpecBody,
}

request! {
    /// Why something is done.
    #[derive(Default)]
    pub struct Why as WhyMembers, read whole {
        /// Reason, which the trace keeps.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
        optional reason: LongText,
    }
}

/// The fit to choose.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ChosenFit)]
pub struct ChosenFitBody {
    /// A fit of this iteration.
    pub fit_id: Uuid,
    /// Reason, which the trace keeps.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub reason: Option<LongText>,
}

/// A decision on the gear, and changes of the nodes' description. Fields that are left out stay
/// unchanged.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = IterationPatch, example = json!({"decision": "remachine", "reason": "profile slope out of tolerance"}))]
pub struct IterationPatchBody {
    /// `accepted` needs a `reason` if a figure does not conform, gross errors are suspected or the
    /// units are implausible. In a job with limits it needs the figures that have limits.
    pub decision: Option<Decision>,
    /// The flank that was measured.
    pub flank: Option<Side>,
    /// The tooth that was measured.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200, example = "1")]
    pub tooth: Option<ShortText>,
    /// Quantities and units on the axes of the nodes. An axis that is left out stays unchanged.
    pub axes: Option<AxesBody>,
    /// Confirms units that seem implausible (`implausible_unit`).
    pub accept_units: Option<bool>,
    /// Reason, which the trace keeps.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub reason: Option<LongText>,
}

impl IterationPatchBody {
    /// Returns true if it changes the measurand of the nodes.
    pub fn says_measurand(&self) -> bool {
        self.flank.is_some() || self.tooth.is_some() || self.axes.is_some() || self.accept_units.is_some()
    }

    /// Returns the measurand of the nodes that it contains.
    pub fn measurand(&self) -> MeasurandBody {
        MeasurandBody { flank: self.flank, tooth: self.tooth.clone(), axes: self.axes.clone() }
    }
}
