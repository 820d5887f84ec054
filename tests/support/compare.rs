//! The one comparator of numbers, and the proof that it can turn red.

/// Largest absolute difference that is let through, and why any is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    pub(crate) absolute: f64,
    pub(crate) reason: &'static str,
}

/// For integers, and for numbers that are only copied or compared.
pub(crate) const EXACT: Tolerance = Tolerance { absolute: 0.0, reason: "nothing is rounded" };

/// Says where `got` is not `want`: an empty list, another length, a NaN, or the worst index.
///
/// # Errors
/// The reason, with `what` in front.
pub(crate) fn compare<T: Copy + Into<f64>, U: Copy + Into<f64>>(
    what: &str,
    got: &[T],
    want: &[U],
    tolerance: Tolerance,
) -> Result<(), String> {
    if want.is_empty() {
        return Err(format!("{what}: nothing to compare with"));
    }
    if got.len() != want.len() {
        return Err(format!("{what}: {} values where {} are wanted", got.len(), want.len()));
    }
    let (mut worst, mut worst_index, mut wrong) = (0.0, 0, 0);
    for (index, (&g, &w)) in got.iter().zip(want).enumerate() {
        let (g, w): (f64, f64) = (g.into(), w.into());
        if !g.is_finite() || !w.is_finite() {
            return Err(format!("{what}[{index}]: {g} where {w} is wanted"));
        }
        let difference = (g - w).abs();
        wrong += usize::from(difference > tolerance.absolute);
        if difference > worst {
            (worst, worst_index) = (difference, index);
        }
    }
    if wrong == 0 {
        return Ok(());
    }
    let (g, w): (f64, f64) = (got[worst_index].into(), want[worst_index].into());
    Err(format!(
        "{what}: {wrong} of {} differ by more than {} ({}); worst [{worst_index}]: {g} where {w} is wanted",
        got.len(),
        tolerance.absolute,
        tolerance.reason
    ))
}

/// [`compare`], failing the test.
#[track_caller]
pub(crate) fn assert_close<T: Copy + Into<f64>, U: Copy + Into<f64>>(
    what: &str,
    got: &[T],
    want: &[U],
    tolerance: Tolerance,
) {
    if let Err(reason) = compare(what, got, want, tolerance) {
        panic!("{reason}");
    }
}

const TENTH: Tolerance = Tolerance { absolute: 0.1, reason: "negative controls" };

#[track_caller]
fn refused(got: &[f32], want: &[f32], tolerance: Tolerance, part: &str) {
    let reason = compare("numbers", got, want, tolerance).unwrap_err();
    assert!(reason.contains(part), "{reason}");
}

#[test]
fn lets_equal_and_near_numbers_through() {
    assert_close("numbers", &[1.0_f32, -2.0], &[1.0_f32, -2.0], EXACT);
    assert_close("numbers", &[1.0_f32, -2.0], &[1.05_f32, -2.05], TENTH);
}

#[test]
fn refuses_what_is_not_comparable() {
    refused(&[], &[], TENTH, "nothing to compare");
    refused(&[1.0], &[1.0, 2.0], TENTH, "1 values where 2");
    refused(&[f32::NAN], &[1.0], TENTH, "[0]: NaN");
    refused(&[1.0], &[f32::NAN], TENTH, "where NaN");
    refused(&[f32::INFINITY], &[f32::INFINITY], TENTH, "inf");
}

#[test]
fn names_the_worst_index() {
    refused(&[1.0, 2.0, 3.5, 4.2], &[1.0, 2.0, 3.0, 4.0], TENTH, "2 of 4 differ");
    refused(&[1.0, 2.0, 3.5, 4.2], &[1.0, 2.0, 3.0, 4.0], TENTH, "worst [2]: 3.5 where 3");
    refused(&[1.0, 2.0], &[1.0, 2.000001], EXACT, "worst [1]");
}
