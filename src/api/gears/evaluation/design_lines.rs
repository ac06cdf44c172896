//! The design lines of the traces of a job.

use super::{
    against::{NO_SECTION, section},
    band::KBandBody,
    request::EvaluationSettingsBody,
};
use crate::api::{
    faults::Faults,
    gears::{
        flank_design::DesignBody,
        requirements::{RequirementsBody, aside},
    },
    warning::WarningBody,
};
use flankfit_engine::gear::{
    Gear, Kind, Side, Trace,
    correction::machine::Ranges,
    evaluation::{self, Against},
    modification::Range,
};

/// Place of the member in a request.
pub const AT: &str = "/evaluation/against";

/// Fills what `settings` leave open by what the job requires, and completes the design lines of
/// traces that need one by the job's design. Bands of the job that need a design line which a trace
/// has not are left aside.
pub fn complete(
    settings: &mut EvaluationSettingsBody,
    required: Option<&RequirementsBody>,
    gear: &Gear,
    traces: &[Trace],
    lines: &mut [Option<Vec<f64>>],
) -> Result<Vec<WarningBody>, Faults> {
    let has_lines = lines.iter().any(Option::is_some);
    let default = if has_lines { Against::Design } else { Against::Involute };
    settings.against = settings.against.or(Some(default));
    let own_bands = settings.k_bands.is_some();
    let mut notices = Vec::new();
    if let Some(required) = required {
        let helix = traces.iter().any(|trace| trace.kind == Kind::Helix);
        notices = required.fill(settings, gear, helix);
    }
    match design_lines(settings, required, gear, traces, lines) {
        Ok(of_job) => {
            notices.extend(of_job.filter(|design| design.lacks_range()).map(|_| {
                WarningBody::new(
                    "design_range_assumed",
                    "the job's design has no range for its figures: the evaluation ranges are assumed; add \
                      `profile_diameter_range_mm` and `helix_range_mm`",
                )
            }));
            Ok(notices)
        }
        Err(faults) if own_bands || settings.against == Some(Against::Design) => Err(faults),
        Err(faults) => {
            let why = faults.list().first().map_or("", |fault| fault.detail.as_str());
            notices.push(aside(&format!("the job's bands about the design: {why}")));
            settings.k_bands.iter_mut().for_each(|bands| bands.retain(|band| !band.is_about_design()));
            Ok(notices)
        }
    }
}

/// Returns the design of the job if a line of it was needed.
fn design_lines<'a>(
    settings: &EvaluationSettingsBody,
    required: Option<&'a RequirementsBody>,
    gear: &Gear,
    traces: &[Trace],
    lines: &mut [Option<Vec<f64>>],
) -> Result<Option<&'a DesignBody>, Faults> {
    let wanted = |trace: &Trace| settings.place_of_design(trace);
    let missing: Vec<(usize, String)> = traces
        .iter()
        .enumerate()
        .filter(|(i, _)| lines[*i].is_none())
        .filter_map(|(i, trace)| Some((i, wanted(trace)?)))
        .collect();
    let Some((_, at)) = missing.first() else { return Ok(None) };
    let Some((required, body)) = required.and_then(|required| Some((required, required.design.as_ref()?))) else {
        let detail = "there is no design: add a `design` to the job's requirements, or send `modifications`";
        return Err(Faults::one(at, detail));
    };
    let refused = |found: &Faults| {
        let why = found.list().first().map_or("", |fault| fault.detail.as_str());
        Faults::one(at, format!("the design that the job requires: {why}"))
    };
    let ranges = settings.ranges(gear).ok_or_else(|| {
        Faults::one(at, "the design needs ranges: send `profile_diameter_range_mm` and `helix_range_mm`")
    })?;
    let of = |side| {
        let design = body.on(gear, side, "").map_err(|found| refused(&found))?;
        design.on(gear, side, ranges, required.figure_terms()).map_err(|found| refused(&found.into()))
    };
    let [left, right] = [of(Side::Left)?, of(Side::Right)?];
    let engine = settings.settings();
    let mut faults = Faults::default();
    for (i, _) in missing {
        let trace = &traces[i];
        let modifications = if trace.side == Side::Left { &left } else { &right };
        match evaluation::design(gear, modifications, trace, &engine) {
            Some(line) => lines[i] = Some(line),
            None => faults.push(section(i, trace), NO_SECTION),
        }
    }
    faults.into_result(Some(body))
}

impl EvaluationSettingsBody {
    /// Returns the place of the member by which a trace needs a design line.
    fn place_of_design(&self, trace: &Trace) -> Option<String> {
        if self.against == Some(Against::Design) {
            return Some(AT.to_owned());
        }
        let bands = self.k_bands.as_deref().unwrap_or_default();
        let of = |band: &KBandBody| band.kind == trace.kind && band.flank.is_none_or(|flank| flank == trace.side);
        let band = bands.iter().position(|band| band.is_about_design() && of(band))?;
        Some(format!("/evaluation/k_bands/{band}/against"))
    }

    /// Returns the evaluation ranges, else those of the whole flank.
    fn ranges(&self, gear: &Gear) -> Option<Ranges> {
        let whole = Range::whole(gear);
        let profile = match self.profile_diameter_range_mm {
            Some([a, b]) => {
                let (a, b) = (gear.roll_length(a)?, gear.roll_length(b)?);
                // from root to tip
                if gear.outward() < 0.0 { [a.max(b), a.min(b)] } else { [a.min(b), a.max(b)] }
            }
            None => whole.as_ref()?.profile(),
        };
        let helix = self.helix_range_mm.or_else(|| whole.as_ref().map(Range::helix))?;
        Some(Ranges { profile, helix: [helix[0].min(helix[1]), helix[0].max(helix[1])] })
    }
}
