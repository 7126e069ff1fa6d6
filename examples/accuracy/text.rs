//! Figures as people write them: two digits.

/// 2 digits, without trailing zeros behind the point.
fn digits(value: f64) -> String {
    let places = (1 - value.abs().max(1e-12).log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.places$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

pub(crate) fn seconds(value: f64) -> String {
    match value {
        v if v < 0.9995e-3 => digits(v * 1e6) + " µs",
        v if v < 0.9995 => digits(v * 1e3) + " ms",
        v => digits(v) + " s",
    }
}

pub(crate) fn percent(value: f64) -> String {
    digits(value * 100.0) + " %"
}

pub(crate) fn bytes(value: f64) -> String {
    match value {
        v if v < 1e6 => digits(v / 1e3) + " kB",
        v if v < 1e9 => digits(v / 1e6) + " MB",
        v => digits(v / 1e9) + " GB",
    }
}

pub(crate) fn times(value: f64) -> String {
    digits(value) + " times"
}

/// With commas between thousands.
pub(crate) fn count(value: u64) -> String {
    let plain = value.to_string();
    let mut text = String::new();
    for (i, digit) in plain.chars().enumerate() {
        if i > 0 && (plain.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// "a, b and c".
pub(crate) fn list(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_two_digits() {
        assert_eq!(seconds(0.004_23), "4.2 ms");
        assert_eq!(seconds(0.000_05), "50 µs");
        assert_eq!(seconds(12.34), "12 s");
        assert_eq!(percent(0.01), "1 %");
        assert_eq!(percent(0.000_25), "0.025 %");
        assert_eq!(bytes(4_511_304.0), "4.5 MB");
        assert_eq!(count(1_234_567), "1,234,567");
        assert_eq!(list(&["a".into(), "b".into(), "c".into()]), "a, b and c");
    }
}
