//! Tables behind the traces: pitch and run-out, places of contact, measured diameters.

use super::{
    super::source::{Line, Lines, append_numbers, number},
    FileError,
};
use flankfit_gear::Side;

/// Deviations of one tooth, µm as stored; NaN where undefined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchRow {
    /// Number of the tooth, from 1.
    pub tooth: u32,
    /// f_p.
    pub single: f64,
    /// F_p up to this tooth.
    pub cumulative: f64,
    /// F_r of this tooth's gap.
    pub runout: f64,
}

/// Pitch of one flank, tooth by tooth.
#[derive(Clone, Debug, PartialEq)]
pub struct PitchTable {
    /// `None` where no title names it.
    pub side: Option<Side>,
    /// One row for each tooth.
    pub rows: Vec<PitchRow>,
    /// Line of the table's head.
    pub line: usize,
}

impl PitchTable {
    /// `Zahn-Nr. fp Fp Fr`: the symbols are the same in every language.
    pub(super) fn is_head(line: Line) -> bool {
        let mut last = line.text.split_ascii_whitespace().rev();
        last.next() == Some("Fr") && last.next() == Some("Fp") && last.next() == Some("fp") && last.next().is_some()
    }

    pub(super) fn parse(head: Line, side: Option<Side>, lines: &mut Lines) -> Result<Self, FileError> {
        let mut rows = Vec::new();
        let mut numbers = Vec::with_capacity(4);
        while let Some(line) = next_row(lines) {
            numbers.clear();
            append_numbers(line.text, &mut numbers).map_err(|piece| line.expected(piece, "a number"))?;
            let [tooth, single, cumulative, runout] = numbers[..] else {
                return Err(line.expected(line.text.trim_start(), "tooth, fp, Fp and Fr"));
            };
            rows.push(PitchRow { tooth: whole(tooth, line)?, single, cumulative, runout });
        }
        Ok(PitchTable { side, rows, line: head.number })
    }

    /// Every deviation.
    pub(super) fn values_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.rows.iter_mut().flat_map(|row| [&mut row.single, &mut row.cumulative, &mut row.runout])
    }
}

/// Place at which a flank was touched when the pitch was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Number of the tooth, from 1.
    pub tooth: u32,
    /// Flank of the tooth.
    pub side: Side,
    /// Angle of the table, degrees as stored.
    pub phi: f64,
    /// Machine coordinates, mm.
    pub point: [f64; 3],
}

impl Contact {
    /// `Z-Nr. Seite PHI X Y Z`
    pub(super) fn is_head(line: Line) -> bool {
        let mut last = line.text.split_ascii_whitespace().rev();
        [Some("Z"), Some("Y"), Some("X"), Some("PHI")].iter().all(|name| last.next() == *name)
    }

    pub(super) fn parse(lines: &mut Lines, out: &mut Vec<Contact>) -> Result<(), FileError> {
        const ROW: &str = "tooth, L or R, angle and three coordinates";
        while let Some(line) = next_row(lines) {
            let mut words = line.text.split_ascii_whitespace();
            let mut word = || words.next().ok_or_else(|| line.expected(line.text.trim_start(), ROW));
            let tooth = word()?;
            let tooth = whole(number(tooth).ok_or_else(|| line.expected(tooth, ROW))?, line)?;
            let side = match word()? {
                "L" | "l" => Side::Left,
                "R" | "r" => Side::Right,
                other => return Err(line.expected(other, "L or R")),
            };
            let mut value = || word().and_then(|word| number(word).ok_or_else(|| line.expected(word, "a number")));
            let (phi, point) = (value()?, [value()?, value()?, value()?]);
            if let Some(extra) = words.next() {
                return Err(line.expected(extra, "the end of the line"));
            }
            out.push(Contact { tooth, side, phi, point });
        }
        Ok(())
    }
}

/// Circle that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhichDiameter {
    /// Root circle.
    Root,
    /// Tip circle.
    Tip,
}

/// Diameters of the measured teeth.
#[derive(Clone, Debug, PartialEq)]
pub struct Diameters {
    /// Root or tip circle.
    pub which: WhichDiameter,
    /// Place on the face width, mm.
    pub z: f64,
    /// mm, in the order of the measured teeth.
    pub values: Vec<f64>,
    /// Line in the file, from 1.
    pub line: usize,
}

impl Diameters {
    /// `Fußkreisdurchmesser / Höhe : 7.500` and a line of numbers; `None` for a line that is
    /// something else.
    pub(super) fn parse(head: Line, lines: &mut Lines) -> Result<Option<Self>, FileError> {
        let Some((label, z)) = head.text.rsplit_once(':').filter(|(label, _)| label.contains('/')) else {
            return Ok(None);
        };
        let label = label.trim_start().to_lowercase();
        let which = match () {
            () if label.starts_with("fu") || label.starts_with("root") => WhichDiameter::Root,
            () if label.starts_with("kopf") || label.starts_with("tip") || label.starts_with("out") => {
                WhichDiameter::Tip
            }
            () => return Ok(None),
        };
        let z = head.number_at(z)?;
        let mut values = Vec::new();
        while let Some(line) = next_row(lines) {
            append_numbers(line.text, &mut values).map_err(|piece| line.expected(piece, "a number"))?;
        }
        Ok(Some(Diameters { which, z, values, line: head.number }))
    }
}

/// The next line if it begins like a number; blank ones are passed over.
fn next_row<'a>(lines: &mut Lines<'a>) -> Option<Line<'a>> {
    while lines.peek()?.is_blank() {
        lines.next();
    }
    lines.peek().filter(Line::is_numeric).and_then(|_| lines.next())
}

fn whole(value: f64, line: Line) -> Result<u32, FileError> {
    let fits = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    if fits { Ok(value as u32) } else { Err(line.expected(line.text.trim_start(), "the number of a tooth")) }
}
