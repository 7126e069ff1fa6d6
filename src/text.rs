use std::time::Duration;

/// A size for people, in decimal units.
pub(crate) fn bytes(count: u64) -> String {
    let value = count as f64;
    match count {
        0..1_000 => format!("{count} B"),
        1_000..1_000_000 => format!("{:.1} kB", value / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", value / 1e6),
        _ => format!("{:.1} GB", value / 1e9),
    }
}

/// A large number for people.
pub(crate) fn count(count: u64) -> String {
    let value = count as f64;
    match count {
        0..1_000_000 => {
            let digits = count.to_string();
            match digits.len() {
                0..=3 => digits,
                n => format!("{},{}", &digits[..n - 3], &digits[n - 3..]),
            }
        }
        1_000_000..1_000_000_000 => format!("{:.1} million", value / 1e6),
        _ => format!("{:.1} billion", value / 1e9),
    }
}

/// A number with its noun, in the plural where it has to be.
#[cfg(feature = "cli")]
pub(crate) fn counted(number: u64, noun: &str) -> String {
    let plural = if number == 1 {
        noun.to_owned()
    } else if let Some(stem) = noun.strip_suffix("ex") {
        format!("{stem}ices")
    } else {
        format!("{noun}s")
    };
    format!("{} {plural}", count(number))
}

/// A time for people.
pub(crate) fn seconds(time: Duration) -> String {
    let s = time.as_secs_f64();
    if s < 0.01 {
        format!("{:.1} ms", 1e3 * s)
    } else if s < 100.0 {
        format!("{s:.2} s")
    } else {
        format!("{} min {:02} s", s as u64 / 60, s as u64 % 60)
    }
}

/// A share in per cent; tiny ones by their order of magnitude.
pub(crate) fn percent(share: f64) -> String {
    let p = 100.0 * share;
    if p == 0.0 || p >= 0.01 {
        format!("{p:.2} %")
    } else {
        format!("{p:.0e} %")
    }
}

/// A quantity of light or length to three digits.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || (0.01..100_000.0).contains(&value.abs()) {
        let digits = if value.abs() >= 100.0 {
            0
        } else if value.abs() >= 1.0 {
            2
        } else {
            3
        };
        format!("{value:.digits$}")
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(all(test, feature = "cli"))]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(bytes(999), "999 B");
        assert_eq!(bytes(1_500_000), "1.5 MB");
        assert_eq!(count(12_345), "12,345");
        assert_eq!(count(2_500_000), "2.5 million");
        assert_eq!(counted(1, "vertex"), "1 vertex");
        assert_eq!(counted(2, "vertex"), "2 vertices");
        assert_eq!(counted(0, "light"), "0 lights");
        assert_eq!(seconds(Duration::from_millis(5)), "5.0 ms");
        assert_eq!(seconds(Duration::from_secs(125)), "2 min 05 s");
        assert_eq!(percent(0.012), "1.20 %");
        assert_eq!(percent(1e-7), "1e-5 %");
        assert_eq!(short(123.4), "123");
        assert_eq!(short(1.234), "1.23");
    }
}
