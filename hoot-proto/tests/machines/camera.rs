//! Camera of a node: hoot, section 4.4.

use super::world::*;
use hoot_proto::device::{CameraState, Options};
use hoot_proto::message::{self, HostMessage, Milliseconds, ShortMilliseconds};

const EXPOSE: HostMessage<'static> = HostMessage::CameraExpose(message::CameraExpose {});

fn node(focus: u16, exposure: u32, delay: u16) -> Node {
    let mut node = Node::new(Options::default());
    node.ok(HostMessage::from(message::CameraSetEnable { enable: YES }));
    let focus_time = ShortMilliseconds(focus);
    node.ok(HostMessage::from(message::CameraSetFocusTime { focus_time }));
    let exposure_time = Milliseconds(exposure);
    node.ok(HostMessage::from(message::CameraSetExposureTime { exposure_time }));
    let exposure_delay = ShortMilliseconds(delay);
    node.ok(HostMessage::from(message::CameraSetExposureDelay { exposure_delay }));
    node
}

fn busy(node: &mut Node) -> [Vec<u8>; 2] {
    [node.ask(HostMessage::from(message::Exposing {})), node.ask(HostMessage::from(message::CameraExposing {}))]
}

// 4.4-1
#[test]
fn a_picture_is_focus_shutter_and_delay() {
    let mut node = node(30, 200, 50);
    assert_eq!(busy(&mut node), [[0, 0], [0, 0]]);
    assert_eq!(node.ok(EXPOSE), [camera(true, false)]);
    let mut states = vec![node.machine.camera().state()];
    assert_eq!(node.pass(30), [(30, camera(false, true))]);
    states.push(node.machine.camera().state());
    assert_eq!(busy(&mut node), [[0, 1], [0, 1]]);
    assert_eq!(node.pass(200), [(200, camera(false, false))]);
    states.push(node.machine.camera().state());
    assert_eq!(busy(&mut node), [[0, 1], [0, 1]], "until the delay is over");
    assert_eq!(node.pass(49), []);
    assert_eq!(states, [CameraState::Focus, CameraState::Exposing, CameraState::Delay]);
    node.pass(1);
    assert_eq!(busy(&mut node), [[0, 0], [0, 0]]);
    assert_eq!(node.wake, None);

    node.ok(HostMessage::from(message::CameraSetFocusWithShutter { focus_with_shutter: YES }));
    node.ok(EXPOSE);
    assert_eq!(node.pass(30), [(30, camera(true, true))]);
}

// 4.4-2
#[test]
fn a_busy_camera_finishes_its_picture() {
    let mut node = node(0, 200, 0);
    assert_eq!(node.ok(EXPOSE), [camera(false, true)], "without focus time the shutter comes first");
    node.pass(150);
    assert_eq!(node.ok(EXPOSE), []);
    assert_eq!(node.pass(50), [(50, camera(false, false))]);
    node.pass(1);
    assert_eq!(busy(&mut node), [[0, 0], [0, 0]]);
}

// 4.4-3
#[test]
fn without_a_camera_nothing_is_released() {
    let mut node = node(0, 200, 0);
    let enable = |enable| HostMessage::from(message::CameraSetEnable { enable });
    node.ok(EXPOSE);
    assert_eq!(node.ok(enable(NO)), [camera(false, false)], "the held lines are released");
    assert_eq!(node.ok(EXPOSE), []);
}

// 4.4-4
#[test]
fn stops_release_the_shutter() {
    for stop in [STOP, PAUSE] {
        let mut node = node(0, 200, 0);
        node.ok(EXPOSE);
        assert_eq!(node.ok(stop), [camera(false, false)]);
        assert_eq!((busy(&mut node), node.wake), ([vec![0, 0], vec![0, 0]], None));
    }
}
