//! Jobs in a list.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::job::JobBody;
use crate::{
    api::{gears::fit_figures::FitFiguresBody, json::text::Moment, page::PageBody},
    jobs::{Decision, JobPage, JobStatus, ListedJob},
};
use flankfit_engine::{
    estimation::inference::{Assumptions, ConformityVerdict},
    gear::{
        Side,
        evaluation::flank_surface::FlankFigures,
        tolerance::{COARSEST, FINEST},
    },
};

/// A job with the status of its last iteration.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ListedJob)]
pub struct ListedJobBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub job: JobBody,
    /// Number of iterations.
    pub iteration_count: u32,
    /// Time when anything of the job was last stored: its data, an iteration, a fit, a choice, a
    /// decision, a record.
    #[schema(value_type = String, format = DateTime, example = "2026-11-21T08:30:00.000000Z")]
    pub changed_at: Moment,
    /// Time of the last iteration's measurement as posted, or when it was stored; absent without
    /// iterations.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub last_measured_at: Option<Moment>,
    /// Flank of the last iteration.
    pub flank: Option<Side>,
    /// Status of the left flanks alone, defined as `status`. Absent if none was measured.
    pub left_status: Option<JobStatus>,
    /// The same for the right flanks.
    pub right_status: Option<JobStatus>,
    /// The latest decision on the last iteration; absent before the first.
    pub decision: Option<Decision>,
    /// Root mean square of the residuals of the last iteration's chosen fit, in the unit of its
    /// heights; absent where it does not exist.
    pub rms: Option<f64>,
    /// Condition number of the scaled Fisher information matrix of that fit; absent where it is
    /// infinite.
    pub condition: Option<f64>,
    /// Slopes, crownings and twist by that fit; absent where the fit has none.
    pub figures: Option<ShortFiguresBody>,
    /// Class of ISO 1328-1, 1 to 11, in the latest evaluation; absent where the evaluation has
    /// none, or where a figure exceeds class 11.
    pub class: Option<u8>,
}

/// The class that is written so.
pub fn class_of(text: &str) -> Result<u8, String> {
    let class = text.parse().ok().filter(|class| (FINEST..=COARSEST).contains(class));
    class.ok_or_else(|| format!("it must be a whole number from {FINEST} to {COARSEST}"))
}

/// Figures of a flank without errors, in µm.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ShortFigures)]
pub struct ShortFiguresBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub figures: FlankFigures,
    /// True if all of them lie within their limits; absent without limits.
    pub within: Option<bool>,
    /// The worst verdict of their conformities; absent without limits.
    pub verdict: Option<ConformityVerdict>,
    /// `doubtful` if the assumptions of a conformity are; absent without limits.
    pub assumptions: Option<Assumptions>,
}

impl ShortFiguresBody {
    /// Reads a stored document; `None` if it has no figure.
    fn of(document: &str) -> Option<Self> {
        let whole: FitFiguresBody = serde_json::from_str(document).ok()?;
        let all: Vec<_> = whole.figures.named().into_iter().filter_map(|(_, figure)| figure).collect();
        let within: Vec<bool> = all.iter().filter_map(|figure| figure.within).collect();
        let conformities = || all.iter().filter_map(|figure| figure.conformity);
        let short = ShortFiguresBody {
            figures: whole.figures.map(|figure| figure.value),
            within: (!within.is_empty()).then(|| within.into_iter().all(|within| within)),
            verdict: conformities().map(|one| one.verdict).max(),
            assumptions: conformities().map(|one| one.assumptions).max(),
        };
        (!all.is_empty()).then_some(short)
    }
}

impl From<ListedJob> for ListedJobBody {
    fn from(listed: ListedJob) -> Self {
        ListedJobBody {
            job: JobBody { requirements: None, ..listed.job.into() },
            iteration_count: listed.iteration_count,
            changed_at: Moment(listed.changed_at),
            last_measured_at: listed.last_measured_at.map(Moment),
            flank: listed.flank,
            left_status: listed.left,
            right_status: listed.right,
            decision: listed.decision,
            rms: listed.rms,
            condition: listed.condition,
            figures: listed.figures.as_deref().and_then(ShortFiguresBody::of),
            class: listed.class,
        }
    }
}

impl From<JobPage> for PageBody<ListedJobBody> {
    fn from(page: JobPage) -> Self {
        PageBody {
            items: page.items.into_iter().map(ListedJobBody::from).collect(),
            next_cursor: page.next.and_then(|next| next.encode()),
        }
    }
}
