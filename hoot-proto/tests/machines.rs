//! The machines, row by row of `docs/machines-hoot.md`, and at random depth. All steps go through `laws::machine::step`.

#[path = "machines/camera.rs"]
mod camera;
#[path = "machines/emergency.rs"]
mod emergency;
#[path = "machines/link.rs"]
mod link;
#[path = "machines/master.rs"]
mod master;
#[path = "machines/motor.rs"]
mod motor;
#[path = "machines/program.rs"]
mod program;
#[path = "machines/random.rs"]
mod random;
#[path = "machines/rows.rs"]
mod rows;
#[path = "machines/settings.rs"]
mod settings;
#[path = "machines/stops.rs"]
mod stops;
#[path = "machines/stream.rs"]
mod stream;
#[path = "machines/world.rs"]
mod world;

/// Sizes for whoever has little memory; `cargo test sizes -- --nocapture` prints them.
#[test]
fn sizes_of_machines_and_outputs() {
    let sizes = [
        ("host::HostMachine", size_of::<hoot_proto::host::HostMachine>(), 1400),
        ("host::Output", size_of::<hoot_proto::host::Output>(), 1700),
        ("device::DeviceMachine", size_of::<hoot_proto::device::DeviceMachine>(), 700),
        ("device::Output", size_of::<hoot_proto::device::Output>(), 1900),
    ];
    for (name, size, most) in sizes {
        println!("{name}: {size} bytes");
        assert!(size <= most, "{name} has grown to {size} bytes");
    }
}
