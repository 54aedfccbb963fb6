//! What decodes, but a strict peer would refuse, or a wise sender would not send.
//!
//! Decoding takes everything; these rules say what is wrong with it. They come from the firmware's habits: it drops the
//! top byte of numbers, reads missing bytes as zero, and acknowledges much that it ignores.
//!
//! ```
//! use hoot_proto::lint::Context;
//! use hoot_proto::message::{Direction, Motor, MotorMove, StepCount};
//! use hoot_proto::{Address, HostMessage};
//!
//! // The firmware would see 0 steps, and run for ever.
//! let motion = MotorMove { motor: Motor::One, direction: Direction(0), steps: StepCount(16_777_216) };
//! let message = HostMessage::MotorMove(motion);
//! let context = Context::default();
//! assert_eq!(message.lint(&context).as_slice()[0].to_string(), "steps: 16777216 is not in 1 to 16777215");
//!
//! let mut out = [0; 64];
//! assert!(message.encode_checked(Address::DEFAULT, &context, &mut out).is_err());
//! ```

use motion_core::lint::{Lints, Problem, Severity};
use motion_core::wire::{DecodeError, EncodeError, Messages, Other, trim_nuls};

use crate::frame::{Address, BREAK, MAX_DATA, Selector};
use crate::message::{
    AnySubAddress, DeviceMessage, Direction, HostMessage, Motor, MotorMove, MotorSetContinuousSpeed, Name, Reply,
    ResponseCode, StepCount, StepsPerSecond, ValueType,
};
use crate::query::Profile;

/// The greatest step rate of any firmware, in steps a second.
const MAX_STEP_RATE: f32 = 10_000.0;

/// What the caller knows of the bus and its nodes: nothing, unless told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Context {
    /// Whether the bus is reached through a bridge, which is every node with USB or Bluetooth.
    pub bridge: bool,
    /// The continuous speeds that the motors of the node were given, motor 1 first, as far as they are known.
    pub speeds: [Option<StepsPerSecond>; 3],
    /// The firmware of the node.
    pub profile: Profile,
}

impl Context {
    /// A bus that is reached through a bridge.
    #[must_use]
    pub fn through_bridge() -> Self {
        Self { bridge: true, ..Self::default() }
    }

    /// Whether a motor is known to have been given the speed 0.
    fn is_still(&self, motor: Motor) -> bool {
        Motor::ALL
            .iter()
            .zip(self.speeds)
            .any(|(one, speed)| *one == motor && speed.is_some_and(|speed| speed.0 == 0.0))
    }
}

impl HostMessage<'_> {
    /// What a node would refuse or misread in this message, and what a wise master would not send.
    ///
    /// It finds nothing in what the constructors of the messages make, as long as the context allows it.
    #[must_use]
    pub fn lint(&self, context: &Context) -> Lints {
        let mut rules = Rules { found: Lints::new(), context };
        match self {
            Self::SetName(message) => rules.name(&message.name),
            Self::MotorSetContinuousSpeed(message) => rules.speed(*message),
            Self::MotorMove(message) => rules.motion(*message),
            Self::MotorRun(message) => {
                rules.direction(message.direction);
                rules.still(message.motor);
            }
            Self::BroadcastStart(message) => rules.broadcast(message.sub_address),
            Self::BroadcastStop(message) => rules.broadcast(message.sub_address),
            Self::BroadcastPause(message) => rules.broadcast(message.sub_address),
            Self::BroadcastAssignAddress(message) => {
                rules.broadcast(message.sub_address);
                rules.found.range("address", message.address.0, 2, u8::MAX);
            }
            Self::Other(other) => match Self::decode_body(other.id(), other.payload()) {
                Ok(Self::Other(_)) => rules.other(other),
                // Somebody made a raw packet of it.
                Ok(known) => return known.lint(context),
                Err(error) => {
                    rules.other(other);
                    rules.other_length(error);
                }
            },
            Self::Start(_)
            | Self::Pause(_)
            | Self::Stop(_)
            | Self::RunStatus(_)
            | Self::Name(_)
            | Self::Voltage(_)
            | Self::MotorStop(_)
            | Self::MotorPosition(_)
            | Self::MotorRunning(_) => {}
        }
        rules.found
    }

    /// [`encode_into`](Self::encode_into), but only if lint finds no error, and not to the master's own address.
    ///
    /// # Errors
    ///
    /// [`EncodeError::Refused`] with the first error that [`lint`](Self::lint) finds, and the errors of
    /// [`encode_into`](Self::encode_into).
    pub fn encode_checked(&self, to: Address, context: &Context, out: &mut [u8]) -> Result<usize, EncodeError> {
        let mut found = self.lint(context);
        found.range("address", to.0, 1, u8::MAX);
        refuse(&found)?;
        self.encode_into(to, out)
    }
}

impl DeviceMessage<'_> {
    /// What a strict master would refuse in this message, and what a wise node would not send.
    ///
    /// It finds nothing in the replies that [`Query::reply`](crate::Query::reply) makes for the profile of the context.
    #[must_use]
    pub fn lint(&self, context: &Context) -> Lints {
        let mut rules = Rules { found: Lints::new(), context };
        match self {
            Self::Reply(reply) => rules.reply(reply),
            Self::Other(other) => {
                rules.length(other.payload());
                rules.found.note(Severity::Warning, "address", "no reply: it is not addressed to the master");
            }
        }
        rules.found
    }

    /// [`encode_into`](Self::encode_into), but only if lint finds no error.
    ///
    /// # Errors
    ///
    /// [`EncodeError::Refused`] with the first error that [`lint`](Self::lint) finds, and the errors of
    /// [`encode_into`](Self::encode_into).
    pub fn encode_checked(&self, context: &Context, out: &mut [u8]) -> Result<usize, EncodeError> {
        refuse(&self.lint(context))?;
        self.encode_into(out)
    }
}

fn refuse(found: &Lints) -> Result<(), EncodeError> {
    found.first_error().map_or(Ok(()), |error| Err(EncodeError::Refused(error)))
}

/// The findings of one message, while its fields are looked at, and what they are measured by.
struct Rules<'c> {
    found: Lints,
    context: &'c Context,
}

impl Rules<'_> {
    fn error(&mut self, what: &'static str, note: &'static str) {
        self.found.note(Severity::Error, what, note);
    }

    fn warning(&mut self, what: &'static str, note: &'static str) {
        self.found.note(Severity::Warning, what, note);
    }

    /// Section 1: the firmware has no room for more, and does not look.
    fn length(&mut self, data: &[u8]) {
        let number = |count| i64::try_from(count).unwrap_or(i64::MAX);
        self.found.range("data", number(data.len()), 0, number(MAX_DATA));
    }

    /// Section 1: whoever searches for the next break would find this one.
    fn no_break(&mut self, what: &'static str, data: &[u8]) {
        if data.windows(BREAK.len()).any(|window| window == BREAK) {
            self.error(what, "holds a break, the start of a packet");
        }
    }

    /// Section 1.2.
    fn name(&mut self, name: &Name) {
        self.no_break("name", name.as_bytes());
        if trim_nuls(name.as_bytes()).contains(&0) {
            self.warning("name", "the node skips NULs inside");
        }
    }

    fn direction(&mut self, direction: Direction) {
        let (value, min, max) = (direction.0.into(), 0, 1);
        if value > max {
            self.found.push(Severity::Warning, "direction", Problem::Range { value, min, max });
        }
    }

    /// Safety decision 3.
    fn motion(&mut self, message: MotorMove) {
        self.direction(message.direction);
        self.found.range("steps", message.steps.0, 1_u8, StepCount::MAX.0);
        self.still(message.motor);
    }

    /// Safety decision 8.
    fn still(&mut self, motor: Motor) {
        if self.context.is_still(motor) {
            self.warning("motor", "nothing moves: its continuous speed is 0");
        }
    }

    /// Section 2.3, command 13.
    fn speed(&mut self, message: MotorSetContinuousSpeed) {
        let speed = message.speed.0;
        self.found.finite("speed", speed);
        if speed.is_finite() && !(-MAX_STEP_RATE..=MAX_STEP_RATE).contains(&speed) {
            self.warning("speed", "beyond the step rate of any firmware, which acknowledges and ignores it");
        }
    }

    /// Section 2.5; safety decision 4.
    fn broadcast(&mut self, sub_address: AnySubAddress) {
        if self.context.bridge {
            self.error("address", "a bridge does not pass broadcasts on: address each node, stops first");
        }
        if sub_address.0 != 0 {
            self.warning("sub_address", "nodes ignore it in broadcasts");
        }
    }

    /// Sections 1 and 2.5.
    fn other(&mut self, other: &Other<'_>) {
        let data = other.payload();
        self.length(data);
        self.no_break("data", data);
        let Selector { broadcast, command, .. } = Selector::from_number(other.id());
        if broadcast && self.context.bridge {
            self.error("address", "a bridge does not pass broadcasts on: address each node");
        }
        if command == 0 {
            self.warning("command", "nodes are silent at command 0, and bridges do not pass it on");
        }
    }

    /// Section 1.1: what the firmware does with a command that has data of another length.
    fn other_length(&mut self, error: DecodeError) {
        if matches!(error, DecodeError::Truncated { .. }) {
            self.error("data", "too short: the node reads missing bytes as zero");
        } else {
            self.warning("data", "longer than the command's: the node leaves out the rest");
        }
    }

    /// Sections 1 and 1.2; safety decision 7.
    fn reply(&mut self, reply: &Reply<'_>) {
        self.length(reply.data);
        self.found.named("response_code", reply.code.0, reply.code.name());
        let Some(value_type) = reply.value_type() else { return };
        if reply.code == ResponseCode::ERROR {
            self.warning("response_code", "an error with data has code 2");
        }
        self.found.named("value_type", value_type.0, value_type.name());
        if value_type.name().is_some() && reply.value().is_none() {
            self.error("value", "longer or shorter than its type");
        }
        if value_type == ValueType::FLOAT && self.context.profile != Profile::Library20140925 {
            self.warning("value", "not reliable: firmware from 2014-10-07 to v0.32 sends garbage as FLOAT");
        }
    }
}
