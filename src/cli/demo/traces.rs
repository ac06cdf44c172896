//! Profile and helix traces of a gear tester as scattered nodes of one flank surface.
//!
//! The table holds one sample a line, with columns for flank, tooth and trace (lead or profile); a
//! tooth has its number, with a letter for traces off the middle (`1`, `1f`, `1k`, `1u`, `1o`). Of
//! each flank the tooth with the most traces is taken: its leads and profiles cross, so together
//! they are a surface. A sample without a deviation is a point that the tester did not reach: it is
//! left out and counted.
//!
//! Signs. The sign of a lead is a convention of its own on many testers (it may count a slope
//! towards one end of the face instead of material), while that of a profile counts material. Where
//! both cross they saw the same point, so there the file itself says whether the leads of a flank
//! count as the profiles do: they are turned when that makes them agree better, and the report says
//! by how much.

use std::collections::BTreeMap;

use super::numbers::short;
use crate::cli::table::Table;
use flankfit_engine::formats::{
    self,
    table::{Meaning, Unit},
};

/// One flank's cross grid, ready to be fitted: positions in mm (roll length, face width), heights
/// in µm.
#[derive(Debug)]
pub struct Flank {
    /// `left, tooth 1`.
    pub name: String,
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    pub z: Vec<f64>,
    /// What was used, for the reader.
    pub report: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Lead,
    Profile,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::Lead => "lead",
            Kind::Profile => "profile",
        }
    }
}

/// One stroke of the probe: `at` is the coordinate that stands still, `points` are (running
/// coordinate, deviation).
#[derive(Default)]
struct Trace {
    at: f64,
    points: Vec<(f64, f64)>,
    undefined: usize,
}

/// Traces of a tooth by kind and tag.
type Tooth = BTreeMap<(Kind, String), Trace>;

/// Every flank's best-covered tooth; `None` where the table has no traces.
pub fn read(table: &formats::Table) -> Option<Vec<Flank>> {
    let (side, tag, kind) = (table.texts(Meaning::Flank)?, table.texts(Meaning::Tooth)?, table.texts(Meaning::Trace)?);
    let roll_length = table.numbers(Meaning::RollLength)?;
    let (z, deviation) = (table.numbers(Meaning::FaceWidth)?, table.numbers(Meaning::Deviation)?);
    let column = table.columns.iter().find(|column| column.meaning == Meaning::Deviation);
    let micrometres = column.and_then(|column| column.unit).and_then(Unit::millimetres).map_or(1.0, |mm| 1e3 * mm);
    let mut flanks: BTreeMap<String, BTreeMap<String, Tooth>> = BTreeMap::new();
    for row in 0..table.rows() {
        let kind = match kind(row).to_lowercase().as_str() {
            "lead" | "helix" | "flankenlinie" => Kind::Lead,
            "profile" | "profil" => Kind::Profile,
            _ => return None,
        };
        let number: String = tag(row).chars().take_while(char::is_ascii_digit).collect();
        let tooth = flanks.entry(side(row).to_owned()).or_default().entry(number).or_default();
        let trace = tooth.entry((kind, tag(row).to_owned())).or_default();
        let (at, running) = match kind {
            Kind::Lead => (roll_length[row], z[row]),
            Kind::Profile => (z[row], roll_length[row]),
        };
        trace.at = at;
        match deviation[row] {
            missing if missing.is_nan() => trace.undefined += 1,
            deviation => trace.points.push((running, micrometres * deviation)),
        }
    }
    Some(flanks.into_iter().filter_map(|(flank, teeth)| cross_grid(&flank, teeth)).collect())
}

fn cross_grid(flank: &str, teeth: BTreeMap<String, Tooth>) -> Option<Flank> {
    // Of equally covered teeth the first stands.
    let best = teeth.iter().rev().max_by_key(|(_, tooth)| tooth.len()).map(|(number, _)| number.clone())?;
    let others: Vec<String> = teeth.keys().filter(|number| **number != best).cloned().collect();
    let tooth = &teeth[&best];

    let sign = lead_sign(tooth);
    let mut nodes = Flank {
        name: format!("{flank}, tooth {best}"),
        u: Vec::new(),
        v: Vec::new(),
        z: Vec::new(),
        report: String::new(),
    };
    let mut table = Table::new(["flank", "tooth", "trace", "at", "samples", "undefined", "used"], 3);
    for ((kind, tag), trace) in tooth {
        for &(running, deviation) in &trace.points {
            let (u, v, z) = match kind {
                Kind::Lead => (trace.at, running, sign.factor() * deviation),
                Kind::Profile => (running, trace.at, deviation),
            };
            nodes.u.push(u);
            nodes.v.push(v);
            nodes.z.push(z);
        }
        let at = match kind {
            Kind::Lead => format!("roll length {} mm", short(trace.at)),
            Kind::Profile => format!("face width {} mm", short(trace.at)),
        };
        table.row([
            flank.to_owned(),
            tag.clone(),
            kind.name().to_owned(),
            at,
            (trace.points.len() + trace.undefined).to_string(),
            trace.undefined.to_string(),
            trace.points.len().to_string(),
        ]);
    }
    nodes.report = format!("{table}  {}\n", sign.sentence());
    if !others.is_empty() {
        nodes.report.push_str(&format!(
            "  Not used: teeth {} of this flank, which have no crossing grid.\n",
            others.join(", ")
        ));
    }
    Some(nodes)
}

/// How leads enter beside profiles, and the rms disagreement at the crossings, in µm, either way.
enum LeadSign {
    NoCrossing,
    AsGiven { as_given: f64, turned: f64 },
    Turned { as_given: f64, turned: f64 },
}

impl LeadSign {
    fn factor(&self) -> f64 {
        if matches!(self, LeadSign::Turned { .. }) { -1.0 } else { 1.0 }
    }

    fn sentence(&self) -> String {
        match self {
            LeadSign::NoCrossing => "Leads and profiles do not cross: signs as in the file.".into(),
            LeadSign::AsGiven { as_given, turned } => format!(
                "Signs as in the file: at the crossings leads and profiles agree within {} µm rms (turned: {} µm).",
                short(*as_given),
                short(*turned)
            ),
            LeadSign::Turned { as_given, turned } => format!(
                "Leads turned to count material as the profiles do: at the crossings they then agree within {} µm rms \
                 (as in the file: {} µm).",
                short(*turned),
                short(*as_given)
            ),
        }
    }
}

fn lead_sign(tooth: &Tooth) -> LeadSign {
    let of = |wanted: Kind| tooth.iter().filter(move |((kind, _), _)| *kind == wanted).map(|(_, trace)| trace);
    let (mut same, mut opposite, mut crossings) = (0.0, 0.0, 0);
    for lead in of(Kind::Lead) {
        for profile in of(Kind::Profile) {
            if let (Some(a), Some(b)) = (lead.height(profile.at), profile.height(lead.at)) {
                same += (a - b).powi(2);
                opposite += (a + b).powi(2);
                crossings += 1;
            }
        }
    }
    if crossings == 0 {
        return LeadSign::NoCrossing;
    }
    let (as_given, turned) = ((same / f64::from(crossings)).sqrt(), (opposite / f64::from(crossings)).sqrt());
    if turned < as_given { LeadSign::Turned { as_given, turned } } else { LeadSign::AsGiven { as_given, turned } }
}

impl Trace {
    /// Deviation at a running coordinate, linear between the neighbouring samples.
    fn height(&self, running: f64) -> Option<f64> {
        self.points.windows(2).find_map(|pair| {
            let ((a, from), (b, to)) = (pair[0], pair[1]);
            let inside = a < b && (a..=b).contains(&running);
            inside.then(|| from + (to - from) * (running - a) / (b - a))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "flank,tooth_tag,trace,sample,diameter_mm,roll_length_mm,z_mm,printed,deviation_um_DIN_sign\n";

    fn file(lead_factor: f64) -> String {
        let mut text = HEADER.to_owned();
        for k in 0..5 {
            let v = f64::from(k);
            text += &format!("right,1,lead,{k},51,7,{v},,{}\n", lead_factor * (2.0 + v));
            text += &format!("right,1,profile,{k},51,{},2,,{}\n", 5 + k, 2.0 + v);
        }
        text += "right,1,lead,5,51,7,5,,\nright,12,lead,0,51,7,0,,1\n";
        text
    }

    fn flanks_of(text: &str) -> Vec<Flank> {
        read(&formats::table::read(text.as_bytes(), &formats::table::Mapping::default()).unwrap()).unwrap()
    }

    #[test]
    fn undefined_points_are_left_out_and_counted() {
        let flanks = flanks_of(&file(1.0));
        assert_eq!(flanks.len(), 1);
        assert_eq!(flanks[0].name, "right, tooth 1");
        assert_eq!(flanks[0].z.len(), 10);
        assert!(flanks[0].report.contains("Not used: teeth 12"), "{}", flanks[0].report);
    }

    #[test]
    fn leads_are_turned_when_the_crossings_say_so() {
        let given = flanks_of(&file(1.0));
        let opposite = flanks_of(&file(-1.0));
        assert_eq!(given[0].z, opposite[0].z);
        assert!(opposite[0].report.contains("Leads turned"), "{}", opposite[0].report);
    }
}
