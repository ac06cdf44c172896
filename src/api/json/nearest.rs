//! Which known name a misspelt one may have been meant to be.

/// The known name that is nearest by insertions, deletions, changes and swaps of neighbours, if a
/// third of it or less would have to be changed. Names of other case, or with other signs between
/// their words, are near at once.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A long name is no typing error.
    let name: Vec<char> = bare(name).take(64).collect();
    let changes = known.into_iter().map(|known| (distance(&name, &bare(known).collect::<Vec<_>>()), known));
    let (changes, found) = changes.min_by_key(|(changes, _)| *changes)?;
    (changes <= (found.len() / 3).max(1) && changes < name.len()).then_some(found)
}

/// The letters and digits of a name.
fn bare(name: &str) -> impl Iterator<Item = char> + '_ {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase)
}

/// Optimal string alignment.
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, y) in b.iter().enumerate() {
            let mut least = (last[j] + usize::from(x != y)).min(last[j + 1] + 1).min(row[j] + 1);
            if i > 0 && j > 0 && *x == b[j - 1] && a[i - 1] == *y {
                least = least.min(before[j - 1] + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_names_are_matched_and_unrelated_ones_are_not() {
        let known = ["teeth", "normal_module_mm", "helix_angle_deg", "type"];
        let near = |name: &str| nearest(name, known);
        assert_eq!(near("theeth"), Some("teeth"));
        assert_eq!(near("teeht"), Some("teeth"));
        assert_eq!(near("helixAngleDeg"), Some("helix_angle_deg"));
        assert_eq!(near("normal_modul"), Some("normal_module_mm"));
        assert_eq!(near("tpye"), Some("type"));
        assert_eq!(near("colour"), None);
        assert_eq!(near(""), None);
        assert_eq!(near("x"), None);
        assert_eq!(nearest("y", ["x"]), None);
        assert_eq!(nearest("teeth", []), None);
    }
}
