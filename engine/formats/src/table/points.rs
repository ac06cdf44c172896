//! Lists of points: `id,x,y,z[,i,j,k]`, mm and directions.

use std::fmt::Write as _;

use crate::{export::node_range, number::real};
use flankfit_geometry::space::Vector;
use flankfit_numerics::check::Faults;

/// A point of a list.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedPoint {
    /// Identifier of the point, where the list has one.
    pub id: Option<String>,
    /// mm.
    pub point: Vector,
    /// i, j, k as given, not zero and not normalised.
    pub direction: Option<Vector>,
    /// Line in its file, from 1; 0 for a point that comes from elsewhere.
    pub line: usize,
}

/// Names of the columns, in the order in which they are written.
const NAMES: [&str; 7] = ["id", "x", "y", "z", "i", "j", "k"];

/// Writes a list, with the columns that any of its points needs. Numbers come back to the last bit.
///
/// ```
/// use flankfit_formats::table::{self, Mapping};
///
/// let list = table::read(b"x,y,z\n1,2,3\n", &Mapping::default())?.points()?;
/// assert_eq!(table::write_points(&list)?, "x,y,z\n1.0,2.0,3.0\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_points(points: &[ListedPoint]) -> Result<String, Faults> {
    let with_id = points.iter().any(|point| point.id.is_some());
    let with_direction = points.iter().any(|point| point.direction.is_some());
    let names = &NAMES[usize::from(!with_id)..if with_direction { 7 } else { 4 }];
    let mut out = names.join(",");
    out.push('\n');
    for (index, listed) in points.iter().enumerate() {
        if with_id {
            let id = field(listed.id.as_deref().unwrap_or_default());
            // a line that begins so would be a comment or a block
            let begins_otherwise = id.starts_with(['%', '/', '!', '*', '[']);
            out.push_str(&if begins_otherwise { format!("\"{id}\"") } else { id });
            out.push(',');
        }
        let finite = |vector: &Vector| vector.iter().all(|x| x.is_finite());
        if !finite(&listed.point) || !listed.direction.as_ref().is_none_or(finite) {
            return Err(Faults::one("", node_range(index)));
        }
        let [x, y, z] = [listed.point.x, listed.point.y, listed.point.z].map(real);
        // writing to a string cannot fail
        let _ = write!(out, "{x},{y},{z}");
        if with_direction {
            match &listed.direction {
                Some(direction) => {
                    let [i, j, k] = [direction.x, direction.y, direction.z].map(real);
                    let _ = write!(out, ",{i},{j},{k}");
                }
                None => out.push_str(",,,"),
            }
        }
        out.push('\n');
    }
    Ok(out)
}

/// A field of a CSV line, in quotes where it needs them; a name has one line.
pub(crate) fn field(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let plain = !text.contains([',', ';', '"', '\t']) && !text.starts_with(['#', ' ']) && !text.ends_with(' ');
    if plain { text } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}
