//! Stops at nodes that hear nothing for a while (decision H-41), with each device by name.

use super::world::*;
use hoot_proto::Address;
use hoot_proto::host::{Command, Event, Options, Request, StopTarget};
use hoot_proto::message::{ProgramMode, SetAddress};
use motion_rigs::device::Named;
use motion_rigs::hoot_master::HootMaster;
use motion_rigs::hoot_node::{HootNode, Setup};
use motion_rigs::{LineId, Party};

/// Stage with a node that has a planned move.
fn prepared(device: &str) -> Stage<HootNode> {
    let mut stage = stage(Setup::default().with_device(device).unwrap());
    stage.enable(ONE, 500.0);
    stage.ok(mode(ProgramMode::VIDEO));
    for message in planned(ONE, 0, smooth()) {
        // Later firmware has a longer lead-in.
        stage.ask(message);
    }
    stage
}

/// Lets an emergency stop be confirmed. Its node still hears, and nothing moves.
#[track_caller]
fn is_stopped(stage: &mut Stage<HootNode>, device: &str, after: u64) {
    stage.pass(8000);
    assert!(!stage.scene.rig.is_hung(), "{device}, {after} ms after the command");
    assert!(stage.has_event(Event::Stopped(StopTarget::All)), "{device}, {after} ms: {:?}", stage.events);
    assert!(stage.is_at_rest() && !stage.may_move(), "{device}, {after} ms after the command");
}

#[test]
fn an_emergency_stop_during_a_start_hangs_no_node() {
    for device in Setup::DEVICES {
        for after in (0..2000).step_by(150) {
            let mut stage = prepared(device.name);
            stage.send_to(NODE, START);
            stage.pass(after);
            stage.command(Command::EmergencyStop);
            stage.pass(100);
            stage.command(Command::EmergencyStop);
            is_stopped(&mut stage, device.name, after);
        }
    }
}

#[test]
fn a_new_master_that_stops_a_node_during_a_start_does_not_hang_it() {
    // The new master stops the node at once, or asks first whether a program runs, as `drive info` does.
    let asks = Command::Request(Request { to: NODE, message: STATUS.into() });
    let keeps = Command::KeepAlive { to: NODE, on: true };
    let cases = [(&[][..], 0), (&[asks, asks], 950), (&[asks, keeps], 1500)];
    let cases = (70..2000).step_by(300).flat_map(|after| cases.map(|case| (after, case)));
    for device in Setup::DEVICES {
        for (after, (commands, stopped_at)) in cases.clone() {
            let mut stage = prepared(device.name);
            stage.send_to(NODE, START);
            stage.pass(after);
            stage.events.clear();
            // The program of the first master was killed.
            let now = stage.scene.now();
            stage.scene.host = HootMaster::new(Options::new());
            stage.scene.rig.close(now, LineId(0));
            stage.scene.rig.open(now, LineId(0));
            stage.scene.host.open(now, LineId(0));
            for &command in commands {
                stage.scene.command((hoot_proto::Token(8), command));
            }
            for at in 0..8000 {
                if at == stopped_at {
                    stage.scene.command((hoot_proto::Token(9), Command::EmergencyStop));
                }
                let until = stage.scene.now().after(1);
                let told = stage.scene.run(until, |_, event| Some(event));
                stage.events.extend(told.into_iter().filter_map(|event| match event {
                    motion_rigs::hoot_master::Event::Machine(event) => Some((0, event)),
                    _ => None,
                }));
            }
            is_stopped(&mut stage, device.name, after);
        }
    }
}

#[test]
fn a_stop_during_a_change_of_the_address_hangs_no_node() {
    for device in Setup::DEVICES {
        for after in [0, 100, 500, 1200, 2400, 3500] {
            let mut stage = prepared(device.name);
            stage.send_to(NODE, SetAddress { new_address: Address(9) });
            stage.pass(after);
            stage.send_to(NODE, STOP);
            stage.send_to(Address(9), STOP);
            stage.send_to(NODE, motor_stop(ONE));
            stage.pass(8000);
            assert!(!stage.scene.rig.is_hung(), "{}, {after} ms after the command", device.name);
        }
    }
}
