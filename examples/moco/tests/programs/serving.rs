//! Tests of the load on a rig that serves.
#![cfg(target_os = "linux")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::process::{Resource, Rlimit, prlimit};

use crate::process::{Rig, within};

/// Processor time of a rig, in hundredths of a second.
fn worked(rig: &Rig) -> u32 {
    let text = std::fs::read_to_string(format!("/proc/{}/stat", rig.id().as_raw_nonzero())).unwrap();
    text.split(' ').skip(13).take(2).map(|ticks| ticks.parse::<u32>().unwrap()).sum()
}

/// Memory that a rig uses, in KiB.
fn memory(rig: &Rig) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{}/status", rig.id().as_raw_nonzero())).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

#[test]
fn a_waiting_rig_uses_almost_no_processor_time() {
    for (test, protocol) in [("waiting_for_dmc", "dmc"), ("waiting_for_hoot", "hoot"), ("waiting_for_kos", "kos")] {
        let rig = Rig::start(test, protocol, &[]);
        rig.drive(&["info"]).done();
        within("the end of the line", || rig.log().contains("the client closed the line").then_some(()));
        let before = worked(&rig);
        sleep(Duration::from_secs(1));
        let work = worked(&rig) - before;
        assert!(work <= 5, "{protocol}: {work} hundredths of a second");
        rig.end();
    }
}

#[test]
fn without_file_handles_no_client_is_accepted_for_a_while() {
    let rig = Rig::start("without_file_handles", "kos", &[]);
    let open = std::fs::read_dir(format!("/proc/{}/fd", rig.id().as_raw_nonzero())).unwrap().count();
    let limit = |more: usize| {
        let most = u64::try_from(open + more).unwrap();
        prlimit(Some(rig.id()), Resource::Nofile, Rlimit { current: Some(most), maximum: Some(1000) }).unwrap();
    };
    limit(1);
    let clients: Vec<_> = (0..3).map(|_| TcpStream::connect(&rig.address).unwrap()).collect();
    within("the warning", || rig.log().contains("no client can be accepted").then_some(()));
    let before = worked(&rig);
    sleep(Duration::from_secs(1));
    let work = worked(&rig) - before;
    assert!(work <= 5, "{work} hundredths of a second");
    limit(100);
    drop(clients);
    rig.drive(&["info"]).done();
    assert_eq!(rig.log().matches("no client can be accepted").count(), 1, "{}", rig.log());
    rig.end();
}

/// Clients that send noise as fast as they can, that never read, and that come and go do not stop another client.
#[test]
fn a_flood_does_not_disturb_other_clients() {
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
            // The client never reads, so it is cut off, or the rig closes the line.
            while line.write_all(&many).is_ok() {
                assert!(start.elapsed() < Duration::from_secs(20), "the client is cut off in time");
            }
        };
        let said = std::thread::scope(|scope| {
            let floods = [(); 2].map(|()| scope.spawn(|| flood(&rig.address)));
            let visits = scope.spawn(|| {
                for _ in 0..200 {
                    let mut line = TcpStream::connect(&rig.address).unwrap();
                    line.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
                    // The answer does not matter.
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
        // There may have been no free line for this client. Then it reported that.
        if !said.status.success() {
            said.failed_somehow();
        }
        within("rest", || rig.drive(&["info"]).status.success().then_some(()));
        let more = memory(&rig).saturating_sub(before);
        assert!(more < 16 * 1024, "{more} KiB more");
        rig.end();
    }
}
