//! By how many teeth the numbers of a later measurement are shifted against those of an earlier
//! one.
//!
//! A gear that is clamped anew may be counted from another tooth. Its single pitch deviations show
//! it: they are correlated, those of both flanks together, at every shift, and the shift with the
//! greatest correlation is taken. Single pitches are used rather than index deviations, because the
//! eccentricity of each clamping is a slow wave that hardly enters them.

use flankfit_numerics::cancel;

/// Number of teeth by which the numbering is shifted after a correction, found by the correlation
/// of the single pitch deviations. It is determined if `correlation` is clearly greater than
/// `next_correlation`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct ToothShift {
    /// Tooth k before is tooth k + `teeth` after, counted around the gear; the positive one if both
    /// are equally near.
    pub teeth: i64,
    /// Correlation of the single pitch deviations before and after, at this shift; at most 1.
    pub correlation: f64,
    /// The greatest correlation at any other shift.
    pub next_correlation: f64,
    /// Correlation without a shift.
    pub unshifted_correlation: f64,
}

/// Single pitch deviations of the left and the right flank, µm; `None` where undefined.
pub type SinglePitches<'a> = [Option<&'a [Option<f64>]>; 2];

/// Returns the shift between two measurements, by the flanks that both have; `None` where they have
/// none in common, of gears of different numbers of teeth, or where the pitches do not vary.
pub fn tooth_shift(before: SinglePitches, after: SinglePitches) -> Option<ToothShift> {
    let flanks: Vec<_> = before.into_iter().zip(after).filter_map(|(before, after)| before.zip(after)).collect();
    let teeth = flanks.first()?.0.len();
    if flanks.iter().any(|(before, after)| before.len() != teeth || after.len() != teeth) {
        return None;
    }
    let at = |shift: usize| {
        cancel::checkpoint();
        let pairs = flanks.iter().flat_map(|(before, after)| {
            (0..teeth).filter_map(move |k| Some([before[k]?, after[(k + shift) % teeth]?]))
        });
        correlation(&pairs.collect::<Vec<[f64; 2]>>())
    };
    let each: Vec<(usize, f64)> = (0..teeth).filter_map(|shift| Some((shift, at(shift)?))).collect();
    let (shift, correlation) = *each.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let others = each.iter().filter(|(other, _)| *other != shift);
    let next = others.map(|(_, found)| *found).max_by(f64::total_cmp)?;
    let (shift, around) = (i64::try_from(shift).ok()?, i64::try_from(teeth).ok()?);
    let teeth = if 2 * shift > around { shift - around } else { shift };
    Some(ToothShift { teeth, correlation, next_correlation: next, unshifted_correlation: at(0)? })
}

fn correlation(pairs: &[[f64; 2]]) -> Option<f64> {
    let mean = |c: usize| pairs.iter().map(|pair| pair[c]).sum::<f64>() / pairs.len() as f64;
    let means = [mean(0), mean(1)];
    let sum = |a: usize, b: usize| pairs.iter().map(|pair| (pair[a] - means[a]) * (pair[b] - means[b])).sum::<f64>();
    let scale = (sum(0, 0) * sum(1, 1)).sqrt();
    (pairs.len() > 2 && scale > 0.0).then(|| (sum(0, 1) / scale).clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(values: &[f64]) -> Vec<Option<f64>> {
        values.iter().copied().map(Some).collect()
    }

    #[test]
    fn the_shift_is_that_of_the_pitches() {
        // tooth 1 before is tooth 3 after
        let before = some(&[1.0, -2.0, 3.0, -4.0, 0.0, 2.0]);
        let after = some(&[0.0, 2.0, 1.0, -2.0, 3.0, -4.0]);
        let found = tooth_shift([Some(&before), None], [Some(&after), None]).unwrap();
        assert_eq!(found.teeth, 2);
        assert!((found.correlation - 1.0).abs() < 1e-12);
        // Σ f² = 34; unshifted 0 − 4 + 3 + 8 + 0 − 8 = −1
        assert!((found.unshifted_correlation + 1.0 / 34.0).abs() < 1e-12, "{found:?}");
        let back = tooth_shift([Some(&after), None], [Some(&before), None]).unwrap();
        assert_eq!((back.teeth, back.unshifted_correlation), (-2, found.unshifted_correlation));
        // an undefined pitch is left out, another flank adds to it
        let mut lost = after.clone();
        lost[4] = None;
        let both = tooth_shift([Some(&before), Some(&before)], [Some(&lost), Some(&after)]).unwrap();
        assert!(both.teeth == 2 && (both.correlation - 1.0).abs() < 1e-12);
    }

    #[test]
    fn without_common_flanks_or_variation_there_is_none() {
        let list = some(&[1.0, -2.0, 3.0, -2.0]);
        assert_eq!(tooth_shift([Some(&list), None], [None, Some(&list)]), None);
        assert_eq!(tooth_shift([Some(&list), None], [Some(&list[..3]), None]), None);
        assert_eq!(tooth_shift([Some(&some(&[0.0; 4])), None], [Some(&list), None]), None);
    }
}
