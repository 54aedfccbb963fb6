//! Test that the table of sizes in `docs/architecture.md` has the sizes of the machines.

#![cfg(target_pointer_width = "64")]

use motion_core::machine;

const DOCUMENT: &str = include_str!("../docs/architecture.md");

/// Row of the table: sizes in bytes, and the number of effects that an output can hold.
fn row<Machine, Session, Transmit, Event, const EFFECTS: usize>(
    name: &str,
    _: fn() -> machine::Output<Transmit, Event, EFFECTS>,
) -> String {
    let output = size_of::<machine::Output<Transmit, Event, EFFECTS>>();
    let effect = size_of::<machine::Effect<Transmit, Event>>();
    let (machine, session) = (size_of::<Machine>(), size_of::<Session>());
    format!("| {name} | {machine} | {output} | {EFFECTS} of {effect} | {session} |")
}

macro_rules! rows {
    ($($name:literal: $protocol:ident $side:ident $machine:ident;)*) => {
        [$(row::<$protocol::$side::$machine, $protocol::$side::Session, _, _, _>(
            $name,
            $protocol::$side::Output::default,
        )),*]
    };
}

#[test]
fn the_table_of_sizes_is_correct() {
    let rows = rows! {
        "kOS client": kos_proto host HostMachine;
        "kOS device": kos_proto device DeviceMachine;
        "DMC host": dmc_proto host HostMachine;
        "DMC device": dmc_proto device DeviceMachine;
        "hoot master": hoot_proto host HostMachine;
        "hoot node": hoot_proto device DeviceMachine;
    };
    let table = rows.join("\n");
    assert!(DOCUMENT.contains(&table), "docs/architecture.md should say:\n{table}");
}
