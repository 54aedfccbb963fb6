//! What a rig bears while it serves.
#![cfg(target_os = "linux")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::process::{Resource, Rlimit, prlimit};

use crate::process::{Rig, within};

/// How long a rig has worked, in hundredths of a second, as `top` tells it.
fn worked(rig: &Rig) -> u32 {
    let text = std::fs::read_to_string(format!("/proc/{}/stat", rig.id().as_raw_nonzero())).unwrap();
    text.split(' ').skip(13).take(2).map(|ticks| ticks.parse::<u32>().unwrap()).sum()
}

/// How much memory a rig uses, in KiB.
fn memory(rig: &Rig) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{}/status", rig.id().as_raw_nonzero())).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

#[test]
fn waiting_costs_nothing() {
    for (test, protocol) in [("waiting_for_dmc", "dmc"), ("waiting_for_hoot", "hoot"), ("waiting_for_kos", "kos")] {
        let rig = Rig::start(test, protocol, &[]);
        rig.drive(&["info"]).done();
        within("the end of the line", || rig.log().contains("has hung up").then_some(()));
        let before = worked(&rig);
        sleep(Duration::from_secs(1));
        let work = worked(&rig) - before;
        assert!(work <= 5, "{protocol}: {work} hundredths of a second");
        rig.end();
    }
}

#[test]
fn without_file_handles_nobody_is_let_in_for_a_while() {
    let rig = Rig::start("without_file_handles", "kos", &[]);
    let open = std::fs::read_dir(format!("/proc/{}/fd", rig.id().as_raw_nonzero())).unwrap().count();
    let limit = |more: usize| {
        let most = u64::try_from(open + more).unwrap();
        prlimit(Some(rig.id()), Resource::Nofile, Rlimit { current: Some(most), maximum: Some(1000) }).unwrap();
    };
    limit(1);
    let clients: Vec<_> = (0..3).map(|_| TcpStream::connect(&rig.address).unwrap()).collect();
    within("trouble", || rig.log().contains("nobody can be let in").then_some(()));
    let before = worked(&rig);
    sleep(Duration::from_secs(1));
    let work = worked(&rig) - before;
    assert!(work <= 5, "{work} hundredths of a second");
    limit(100);
    drop(clients);
    rig.drive(&["info"]).done();
    assert_eq!(rig.log().matches("nobody can be let in").count(), 1, "{}", rig.log());
    rig.end();
}

/// Clients who say nonsense as fast as they can, who never read, and who come and go, while another one does his work.
#[test]
fn floods_hurt_nobody() {
    for (test, protocol, question) in [
        // DeviceInfo, whose answer is long.
        ("a_flood_of_kos", "kos", b"\x04\0\x06\0\x0F\x01".as_slice()),
        ("a_flood_of_noise_for_kos", "kos", b"\x09noise".as_slice()),
    ] {
        let rig = Rig::start(test, protocol, &["--motors", "2"]);
        rig.drive(&["info"]).done();
        let before = memory(&rig);
        let many = question.repeat(10_000);
        let flood = |address: &str| {
            let mut line = TcpStream::connect(address).unwrap();
            line.set_write_timeout(Some(Duration::from_secs(5))).unwrap();
            let start = Instant::now();
            // It never reads, and is cut off; or the rig has hung up.
            while line.write_all(&many).is_ok() {
                assert!(start.elapsed() < Duration::from_secs(20), "it is not cut off");
            }
        };
        let said = std::thread::scope(|scope| {
            let floods = [(); 2].map(|()| scope.spawn(|| flood(&rig.address)));
            let visits = scope.spawn(|| {
                for _ in 0..200 {
                    let mut line = TcpStream::connect(&rig.address).unwrap();
                    line.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
                    // Whatever it says, or nothing.
                    let _ = line.read(&mut [0; 64]);
                }
            });
            let said = rig.drive(&["calibrate", "1", "0", "5"]);
            for flood in floods {
                flood.join().unwrap();
            }
            visits.join().unwrap();
            said
        });
        // Perhaps there was no room for him; then he was told.
        if !said.status.success() {
            said.failed("drive: ");
        }
        within("rest", || rig.drive(&["info"]).status.success().then_some(()));
        let more = memory(&rig).saturating_sub(before);
        assert!(more < 16 * 1024, "{more} KiB more");
        rig.end();
    }
}
