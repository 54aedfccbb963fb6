//! Tests of the machines: each row of `docs/machines-hoot.md`, and random inputs. All steps go through
//! `laws::machine::step`.

#[path = "machines/camera.rs"]
mod camera;
#[path = "machines/conduct.rs"]
mod conduct;
#[path = "machines/deaf.rs"]
mod deaf;
#[path = "machines/emergency.rs"]
mod emergency;
#[path = "machines/host.rs"]
mod host;
#[path = "machines/joystick.rs"]
mod joystick;
#[path = "machines/link.rs"]
mod link;
#[path = "machines/motor.rs"]
mod motor;
#[path = "machines/moving.rs"]
mod moving;
#[path = "machines/program.rs"]
mod program;
#[path = "machines/random.rs"]
mod random;
#[path = "machines/real.rs"]
mod real;
#[path = "machines/rows.rs"]
mod rows;
#[path = "machines/session.rs"]
mod session;
#[path = "machines/settings.rs"]
mod settings;
#[path = "machines/stops.rs"]
mod stops;
#[path = "machines/world.rs"]
mod world;

/// Sizes of the machines, for programs with little memory; `cargo test sizes -- --nocapture` prints them.
#[test]
fn sizes_of_machines_and_outputs() {
    let sizes = [
        ("host::HostMachine", size_of::<hoot_proto::host::HostMachine>(), 2200),
        ("host::Output", size_of::<hoot_proto::host::Output<'_>>(), 2700),
        ("device::DeviceMachine", size_of::<hoot_proto::device::DeviceMachine>(), 700),
        ("device::Output", size_of::<hoot_proto::device::Output<'_>>(), 2900),
    ];
    for (name, size, most) in sizes {
        println!("{name}: {size} bytes");
        assert!(size <= most, "{name} has grown to {size} bytes");
    }
}
