use super::failure::Failure;
use super::text::bytes;

/// An error if a bake needs more memory than is free: a machine that swaps is worse than none.
pub(super) fn check(needed: u64) -> Result<(), Failure> {
    match available() {
        Some(available) => compare(needed, available),
        None => Ok(()),
    }
}

fn compare(needed: u64, available: u64) -> Result<(), Failure> {
    if needed <= available {
        return Ok(());
    }
    Err(Failure::Error(format!(
        "the bake needs about {} of memory and {} are free: raise --max-edge, lower --elements, or \
         close other programs",
        bytes(needed),
        bytes(available)
    )))
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
    fn too_much_names_the_cure() {
        assert!(compare(10, 10).is_ok());
        let Err(Failure::Error(message)) = compare(3 << 30, 1 << 30) else {
            panic!("it fits");
        };
        assert!(
            message.contains("--max-edge") && message.contains("3.2 GB"),
            "{message}"
        );
    }
}
