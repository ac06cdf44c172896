//! Jobs as they are listed.

use crate::jobs::ListedJob;

from_row! {
    ListedJob {
        @job, iteration_count, changed_at, last_measured_at, flank, left = "left_status",
        right = "right_status", decision, rms, condition, figures = "flank_figures", class,
    }
}

row! {
    /// A job with its place in the order by name.
    pub struct NamedJob {
        @pub listed: ListedJob,
        pub sort_name: String,
    }
}
