//! Tables of pitches of a gear tester, evaluated.

use crate::api::{
    gears::{
        evaluation::pitch::{PitchEvaluationBody, PitchMeasuredBody, PitchRequestBody},
        gear::GearBody,
        requirements::RequirementsBody,
    },
    warning::WarningBody,
};
use flankfit_engine::{
    formats::klingelnberg::{Curves, PitchRow, PitchTable},
    gear::{
        Gear, Side,
        evaluation::runout::{self, Counting},
    },
};

/// Pitches of a file.
pub struct FilePitch {
    /// As they would be posted to be evaluated again.
    pub request: PitchRequestBody,
    pub found: PitchEvaluationBody,
}

/// Evaluates the tables of a file, where it has any; what cannot be is a warning.
pub(super) fn read(
    curves: &Curves,
    gear: &Gear,
    accept_units: Option<bool>,
    required: Option<&RequirementsBody>,
    warnings: &mut Vec<WarningBody>,
) -> Option<FilePitch> {
    let gear_body = Some(GearBody::from(gear.data()));
    let mut request = PitchRequestBody { gear: gear_body, accept_units, ..PitchRequestBody::default() };
    let mut warn = |code: &str, message: String| warnings.push(WarningBody::new(code, &message));
    for table in &curves.pitch {
        let line = table.line;
        let Some(side) = table.side else {
            warn("pitch_without_flank", format!("line {line}: no title names the flank of these pitches"));
            continue;
        };
        let place = match side {
            Side::Left => &mut request.left,
            Side::Right => &mut request.right,
        };
        if place.is_some() {
            warn("pitch_repeated", format!("line {line}: a second table of the same flank; the first is used"));
            continue;
        }
        match Columns::of(table, gear.data().teeth) {
            Err(why) => warn("pitch_not_read", format!("line {line}: {why}")),
            Ok(Columns { cumulative, runout }) => {
                *place = Some(PitchMeasuredBody { index_deviation_um: Some(cumulative), ..Default::default() });
                // readings are of the spaces, the same in both tables
                let read = runout.iter().any(Option::is_some);
                request.readings_um = request.readings_um.take().or(Some(runout).filter(|_| read));
            }
        }
    }
    if request.left.is_none() && request.right.is_none() {
        return None;
    }
    let mut notices: Vec<WarningBody> = Vec::new();
    request.counting = counting(curves, &request, &mut notices);
    notices.extend(required.and_then(|required| required.fill_pitch(&mut request.pitch_limits, gear)));
    match request.evaluated(gear) {
        Ok(mut found) => {
            found.warnings.extend(notices);
            found.tooth_thickness = curves.thickness(gear);
            Some(FilePitch { request, found })
        }
        Err(faults) => {
            let why: Vec<&str> = faults.list().iter().map(|fault| fault.detail.as_str()).collect();
            warn("pitch_not_evaluated", format!("pitches are not evaluated: {}", why.join("; ")));
            None
        }
    }
}

/// Least correlation of pitches and run-out that determines the direction of counting.
const DECIDES: f64 = 0.9;

/// Returns the direction in which the teeth of a file are counted: from code 161, or from the
/// file's own run-out.
fn counting(curves: &Curves, request: &PitchRequestBody, notices: &mut Vec<WarningBody>) -> Option<Counting> {
    let index = |flank: &Option<PitchMeasuredBody>| flank.as_ref()?.index_deviation_um.clone();
    let both = index(&request.left).zip(index(&request.right)).zip(request.readings_um.clone());
    let agreement = |counting: Counting| {
        let ((left, right), readings) = both.as_ref()?;
        runout::agreement(left, right, readings, counting)
    };
    let mut notice = |code: &str, message: String| notices.push(WarningBody::new(code, &message));
    if let Some(setting) = curves.header.rules().by_spaces.filter(|setting| *setting != 0) {
        let message = format!(
            "code 163 is {setting}: the assignment of flanks to a tooth number is not known; pitches of each flank do \
             not depend on it, a run-out from both does"
        );
        notice("pitch_sign_assumed", message);
        return None;
    }
    match curves.header.rules().counting {
        Some(said) => {
            if let Some(found) = agreement(said).filter(|found| *found < -DECIDES) {
                let message = format!(
                    "code 161 says that teeth are counted {}, which contradicts the file's run-out (correlation \
                     {found:.2}): check the direction or the sign of the pitches",
                    said.word()
                );
                notice("counting_contradicted", message);
            }
            Some(said)
        }
        None => {
            let each = [Counting::Clockwise, Counting::Counterclockwise];
            let best = each.into_iter().filter_map(|counting| Some((counting, agreement(counting)?)));
            let told = best.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, found)| *found >= DECIDES);
            let message = match told {
                Some((counting, found)) => format!(
                    "the file does not give the direction of counting (code 161); its run-out shows {} (correlation \
                     {found:.2})",
                    counting.word()
                ),
                None => "the file does not give the direction of counting (code 161): amounts and classes of each \
                    flank's pitches do not depend on it; their signs, the direction of the eccentricity and a \
                    run-out from pitches do"
                    .to_owned(),
            };
            notice("pitch_sign_assumed", message);
            told.map(|(counting, _)| counting)
        }
    }
}

/// Columns of a table, a number for each tooth.
struct Columns {
    cumulative: Vec<Option<f64>>,
    runout: Vec<Option<f64>>,
}

impl Columns {
    fn of(table: &PitchTable, teeth: u32) -> Result<Self, String> {
        let none = || vec![None; teeth as usize];
        let mut columns = Columns { cumulative: none(), runout: none() };
        let mut seen = vec![false; teeth as usize];
        let defined = |value: f64| Some(value).filter(|value| !value.is_nan());
        for PitchRow { tooth, cumulative, runout, .. } in &table.rows {
            let Some(k) = tooth.checked_sub(1).filter(|_| *tooth <= teeth).map(|k| k as usize) else {
                return Err(format!("a gear of {teeth} teeth has no tooth {tooth}"));
            };
            if std::mem::replace(&mut seen[k], true) {
                return Err(format!("tooth {tooth} occurs twice"));
            }
            columns.cumulative[k] = defined(*cumulative);
            columns.runout[k] = defined(*runout);
        }
        Ok(columns)
    }
}
