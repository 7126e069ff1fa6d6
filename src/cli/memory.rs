use super::failure::Failure;
use crate::text::bytes;

/// An error if a bake needs more memory than it may have: what is free unless said, because a
/// machine that swaps is worse than none.
pub(super) fn check(needed: u64, allowed: Option<u64>) -> Result<(), Failure> {
    match allowed {
        Some(allowed) => compare(needed, allowed, "are allowed by --max-memory"),
        None => available().map_or(Ok(()), |free| compare(needed, free, "are free")),
    }
}

fn compare(needed: u64, limit: u64, limits: &str) -> Result<(), Failure> {
    if needed <= limit {
        return Ok(());
    }
    Err(Failure::Error(format!(
        "the bake needs about {} of memory and {} {limits}: raise --max-edge, lower --elements, use \
         --form-factors hit-list, or close other programs",
        bytes(needed),
        bytes(limit)
    )))
}

/// Reads a number of bytes, with a unit or without.
pub(super) fn amount(text: &str) -> Result<u64, String> {
    let text = text.trim().trim_end_matches(['B', 'b']);
    let units = [('k', 1e3), ('K', 1e3), ('M', 1e6), ('G', 1e9), ('T', 1e12)];
    let unit = units.iter().find(|u| text.ends_with(u.0));
    let (number, factor) = unit.map_or((text, 1.0), |u| (&text[..text.len() - 1], u.1));
    let number = number.trim().parse::<f64>().ok();
    number
        .filter(|n| n.is_finite() && *n > 0.0)
        .map(|n| (n * factor) as u64)
        .ok_or_else(|| "give a number of bytes, like 500M or 4G".into())
}

/// Bytes that can be had without swapping; `None` where the system does not say.
#[cfg(target_os = "linux")]
fn available() -> Option<u64> {
    use std::fs::read_to_string;

    let machine = mem_available(&read_to_string("/proc/meminfo").ok()?)?;
    // A container may be allowed less than the machine has.
    let number = |name: &str| -> Option<u64> {
        let text = read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?;
        text.trim().parse().ok()
    };
    let container = number("memory.max")
        .zip(number("memory.current"))
        .map(|(limit, used)| limit.saturating_sub(used));
    Some(container.map_or(machine, |c| c.min(machine)))
}

#[cfg(not(target_os = "linux"))]
fn available() -> Option<u64> {
    None
}

#[cfg(any(target_os = "linux", test))]
fn mem_available(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find(|l| l.starts_with("MemAvailable:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_linux_says() {
        let text = "MemTotal:  100 kB\nMemFree:  1 kB\nMemAvailable:   42 kB\n";
        assert_eq!(mem_available(text), Some(42 * 1024));
        assert_eq!(mem_available("MemTotal: 100 kB"), None);
    }

    #[test]
    fn amounts_have_units() {
        assert_eq!(amount("500M"), Ok(500_000_000));
        assert_eq!(amount("1.5 GB"), Ok(1_500_000_000));
        assert_eq!(amount("4096"), Ok(4096));
        assert!(amount("-1").is_err() && amount("lots").is_err() && amount("").is_err());
    }

    #[test]
    fn too_much_names_the_cure() {
        assert!(compare(10, 10, "are free").is_ok());
        let Err(Failure::Error(message)) = compare(3 << 30, 1 << 30, "are free") else {
            panic!("it fits");
        };
        assert!(
            message.contains("--max-edge") && message.contains("3.2 GB"),
            "{message}"
        );
    }
}
