//! Tests with machines that consist of files.

use super::*;
use std::path::Path;

/// Writes files, with their folders, below a new folder.
pub(in crate::bench) fn machine(files: &[(&str, &str)]) -> tempfile::TempDir {
    let root = tempfile::tempdir().expect("a folder");
    for (path, text) in files {
        write(root.path(), path, text);
    }
    root
}

pub(in crate::bench) fn write(root: &Path, path: &str, text: &str) {
    let path = root.join(path);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    std::fs::write(path, text).expect("written");
}

fn arm_cpu(number: usize, part: &str) -> String {
    format!(
        "processor\t: {number}\nBogoMIPS\t: 108.00\nFeatures\t: fp asimd evtstrm crc32 cpuid\n\
         CPU implementer\t: 0x41\nCPU architecture: 8\nCPU variant\t: 0x0\nCPU part\t: {part}\nCPU revision\t: 3\n\n"
    )
}

/// The files of a Raspberry Pi 4 Model B on Linux 6.6.
fn raspberry_pi_4() -> tempfile::TempDir {
    let cpus: String = (0..4).map(|cpu| arm_cpu(cpu, "0xd08")).collect();
    let policy = "sys/devices/system/cpu/cpufreq/policy0";
    let root = machine(&[
        ("proc/device-tree/model", "Raspberry Pi 4 Model B Rev 1.4\0"),
        (
            "proc/device-tree/compatible",
            "raspberrypi,4-model-b\0brcm,bcm2711\0",
        ),
        (
            "proc/cpuinfo",
            &format!("{cpus}Revision\t: c03114\nModel\t\t: Raspberry Pi 4 Model B Rev 1.4\n"),
        ),
        (
            "proc/meminfo",
            "MemTotal:        3880372 kB\nMemFree:  100 kB\n",
        ),
        ("proc/sys/kernel/osrelease", "6.6.51+rpt-rpi-v8\n"),
        (
            "proc/self/status",
            "Name:\tedgegait\nCpus_allowed_list:\t0,2-3\n",
        ),
        (&format!("{policy}/affected_cpus"), "0 1 2 3\n"),
        (&format!("{policy}/scaling_governor"), "ondemand\n"),
        (&format!("{policy}/scaling_min_freq"), "600000\n"),
        (&format!("{policy}/scaling_cur_freq"), "1500000\n"),
        (&format!("{policy}/scaling_max_freq"), "1500000\n"),
        ("sys/class/thermal/thermal_zone0/temp", "48686\n"),
        (
            "sys/devices/platform/soc/soc:firmware/get_throttled",
            "50005\n",
        ),
    ]);
    for cpu in 0..4 {
        let path = format!("sys/devices/system/cpu/cpu{cpu}/cpufreq/cpuinfo_max_freq");
        write(root.path(), &path, "1500000\n");
    }
    root
}

#[test]
fn a_raspberry_pi_4_is_described() {
    let root = raspberry_pi_4();
    let board = Board::read(root.path());
    assert_eq!(
        board.model.as_deref(),
        Some("Raspberry Pi 4 Model B Rev 1.4")
    );
    assert_eq!(board.soc.as_deref(), Some("brcm,bcm2711"));
    let [group] = board.cpus.as_slice() else {
        panic!("four that are alike: {:?}", board.cpus);
    };
    assert_eq!(group.cpus.to_string(), "0-3");
    assert_eq!(group.name.as_deref(), Some("Cortex-A72"));
    assert_eq!(group.part.as_deref(), Some("0x41/0xd08"));
    assert_eq!((group.capacity, group.max_khz), (None, Some(1_500_000)));
    assert_eq!(board.affinity.expect("told").numbers(), [0, 2, 3]);
    assert_eq!(board.features, ["asimd"]);
    assert_eq!(board.ram_bytes, Some(3_880_372 * 1024));
    assert_eq!(board.kernel.as_deref(), Some("6.6.51+rpt-rpi-v8"));

    let state = MachineState::read(root.path());
    assert_eq!(state.temperature_c, Some(48.686));
    assert_eq!(state.throttled, Some(0x50005));
    assert_eq!(state.throttle_count, None);
    let [clock] = state.clocks.as_slice() else {
        panic!("one clock: {:?}", state.clocks);
    };
    assert_eq!(clock.governor.as_deref(), Some("ondemand"));
    let khz = [clock.min_khz, clock.current_khz, clock.max_khz];
    assert_eq!(khz, [600_000, 1_500_000, 1_500_000].map(Some));
    // Bits 0 and 2 are on.
    assert_eq!(
        warnings(&[state], None),
        [
            "the firmware reported under-voltage while this was measured",
            "the firmware reported throttling while this was measured"
        ]
    );
}

#[test]
fn little_and_big_processors_are_separate_groups() {
    // An RK3588: four Cortex-A55, two clusters of two Cortex-A76.
    let parts = [
        "0xd05", "0xd05", "0xd05", "0xd05", "0xd0b", "0xd0b", "0xd0b", "0xd0b",
    ];
    let cpus: String = parts
        .iter()
        .enumerate()
        .map(|(cpu, part)| arm_cpu(cpu, part))
        .collect();
    let root = machine(&[
        ("proc/cpuinfo", &cpus),
        ("sys/devices/soc0/family", "Rockchip\n"),
        ("sys/devices/soc0/soc_id", "RK3588\n"),
        (
            "proc/device-tree/compatible",
            "radxa,rock-5b\0rockchip,rk3588\0",
        ),
        ("sys/class/thermal/thermal_zone0/temp", "40000\n"),
        ("sys/class/thermal/thermal_zone1/temp", "43461\n"),
        ("sys/class/thermal/thermal_zone2/temp", "-274000\n"),
    ]);
    for (cpu, (capacity, khz)) in [(414, 1_800_000), (1024, 2_400_000)]
        .iter()
        .flat_map(|kind| [kind; 4])
        .enumerate()
    {
        let folder = format!("sys/devices/system/cpu/cpu{cpu}");
        write(
            root.path(),
            &format!("{folder}/cpu_capacity"),
            &capacity.to_string(),
        );
        write(
            root.path(),
            &format!("{folder}/cpufreq/cpuinfo_max_freq"),
            &khz.to_string(),
        );
    }
    let board = Board::read(root.path());
    assert_eq!(board.soc.as_deref(), Some("Rockchip RK3588"));
    let found: Vec<_> = board
        .cpus
        .iter()
        .map(|group| {
            (
                group.cpus.to_string(),
                group.name.clone().expect("known"),
                group.capacity,
            )
        })
        .collect();
    assert_eq!(
        found,
        [
            ("0-3".to_owned(), "Cortex-A55".to_owned(), Some(414)),
            ("4-7".to_owned(), "Cortex-A76".to_owned(), Some(1024)),
        ]
    );
    assert_eq!(MachineState::read(root.path()).temperature_c, Some(43.461));
}

#[test]
fn what_a_machine_does_not_expose_is_absent() {
    let root = machine(&[]);
    let board = Board::read(root.path());
    let bare = Board {
        architecture: std::env::consts::ARCH.into(),
        libc: board.libc.clone(),
        ..Board::default()
    };
    assert_eq!(board, bare);
    assert_eq!(MachineState::read(root.path()), MachineState::default());
    assert_eq!(
        warnings(&[MachineState::default(), MachineState::default()], None),
        [""; 0]
    );
    let json = serde_json::to_value(MachineState::default()).expect("plain data");
    assert_eq!(json, serde_json::json!({}));
}

#[test]
fn a_pc_is_named_by_its_firmware() {
    let root = machine(&[
        ("sys/class/dmi/id/sys_vendor", "LENOVO\n"),
        ("sys/class/dmi/id/product_name", "20XW\n"),
        (
            "proc/cpuinfo",
            "processor\t: 0\nvendor_id\t: GenuineIntel\ncpu family\t: 6\nmodel\t\t: 140\nmodel name\t: 11th Gen Intel(R) Core(TM) i7\nflags\t\t: fpu sse4_2 avx2 avx512f avx512_vnni\n\nprocessor\t: 1\nvendor_id\t: GenuineIntel\ncpu family\t: 6\nmodel\t\t: 140\nmodel name\t: 11th Gen Intel(R) Core(TM) i7\nflags\t\t: fpu sse4_2 avx2 avx512f avx512_vnni\n",
        ),
        (
            "sys/devices/system/cpu/cpu0/thermal_throttle/core_throttle_count",
            "3\n",
        ),
        (
            "sys/devices/system/cpu/cpu1/thermal_throttle/core_throttle_count",
            "4\n",
        ),
    ]);
    let board = Board::read(root.path());
    assert_eq!(board.model.as_deref(), Some("LENOVO 20XW"));
    assert_eq!(board.cpus.len(), 1);
    assert_eq!(board.cpus[0].part.as_deref(), Some("family 6 model 140"));
    assert_eq!(board.features, ["sse4_2", "avx2", "avx512f", "avx512_vnni"]);
    let before = MachineState::read(root.path());
    assert_eq!(before.throttle_count, Some(7));
    write(
        root.path(),
        "sys/devices/system/cpu/cpu1/thermal_throttle/core_throttle_count",
        "6\n",
    );
    assert_eq!(
        warnings(&[before, MachineState::read(root.path())], None),
        ["cores were throttled 2 times while this was measured"]
    );
}

/// A state whose processors 0 to 3 and 4 run at these frequencies.
fn at_khz(khz: u64, other_khz: u64) -> MachineState {
    let clock = |cpus, khz| Clock {
        cpus: CpuList::parse(cpus).expect("a list"),
        governor: None,
        min_khz: None,
        current_khz: Some(khz),
        max_khz: None,
    };
    MachineState {
        clocks: vec![clock("0-3", khz), clock("4", other_khz)],
        ..MachineState::default()
    }
}

#[test]
fn a_frequency_that_drops_by_more_than_5_percent_is_warned_of() {
    let cpus = CpuList::parse("1");
    let of = |khz: [u64; 3]| {
        // Idle at first. The frequency of an unused processor does not matter.
        let states = khz.map(|khz| at_khz(khz, 3_000_000 - khz));
        warnings(
            &[&[at_khz(600_000, 600_000)], states.as_slice()].concat(),
            cpus.as_ref(),
        )
    };
    assert_eq!(of([1_500_000, 1_500_000, 1_425_000]), [""; 0]);
    assert_eq!(
        of([1_500_000, 1_200_000, 1_500_000]),
        ["the processors' frequency dropped by 20 % while this was measured"]
    );
    assert_eq!(of([1_200_000, 1_300_000, 1_500_000]), [""; 0]);
}

#[test]
fn lists_of_processors_are_read_and_written_as_linux_does() {
    for (text, written) in [
        ("0-3,6", "0-3,6"),
        ("3 1 2 0", "0-3"),
        ("5", "5"),
        ("0,2,4-5", "0,2,4-5"),
    ] {
        let list = CpuList::parse(text).expect("a list");
        assert_eq!(list.to_string(), written);
        let json = serde_json::to_string(&list).expect("plain data");
        assert_eq!(
            serde_json::from_str::<CpuList>(&json).expect("our own"),
            list
        );
    }
    for wrong in ["", "a", "3-1", "0-", "-1", "0-99999999"] {
        assert_eq!(CpuList::parse(wrong), None, "{wrong}");
    }
}
