//! Options of a client machine, given once at its start.

use motion_core::options;

use crate::discovery::ANNOUNCE_EVERY;
use crate::times::some_time;

/// Identity of a device and of the platform that calibrated its motors (safety decision 9).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Identity {
    /// Number of the device.
    pub guid: [u8; 16],
    /// Number of the platform.
    pub platform: u8,
}

options! {
    /// Options of a client. Times are in milliseconds.
    pub struct Options {
        /// Time between questions by datagram while nobody is connected, from the first call on. `None` asks nothing:
        /// devices announce themselves.
        ask_every with_ask_every: Option<u64> = None, by some_time;
        /// Time to wait for the answer to a question.
        request_timeout with_request_timeout: u64 = 3000, in 1..=u64::MAX;
        /// Time without a message, sent or received, after which the line over TCP is kept alive, as specified.
        tcp_keep_alive with_tcp_keep_alive: u64 = 10_000, in 1..=u64::MAX;
        /// Time between keep-alives over USB, as specified.
        usb_keep_alive with_usb_keep_alive: u64 = 4000, in 1..=u64::MAX;
        /// Silence of the device after which the connection over TCP is given up: two unanswered keep-alives.
        silence with_silence: u64 = 25_000, in 1..=u64::MAX;
        /// Time to wait for the confirmation of a stop before it is sent again.
        stop_timeout with_stop_timeout: u64 = 2000, in 1..=u64::MAX;
        /// Time after which a move that is not ready or does not begin, and a motor that does not rest, is told to be
        /// slow. The way may be long.
        setup_timeout with_setup_timeout: u64 = 120_000, in 1..=u64::MAX;
        /// Time between two commands to one motor: twenty a second, which devices are known to bear.
        motor_interval with_motor_interval: u64 = 50, in 1..=u64::MAX;
        /// Time in which the application has to give a command while it jogs a motor. After it the motor is stopped.
        dead_man with_dead_man: u64 = 1000, in 1..=u64::MAX;
        /// Whether the password that the device tells is sent back, as the public client does. Otherwise the application
        /// has one.
        echo_password with_echo_password: bool = true;
        /// Whether a connection that is lost is made again.
        reconnect with_reconnect: bool = true;
        /// Time before the first try to connect again. It doubles with each try, up to 32 times.
        back_off with_back_off: u64 = 1000, in 1..=u64::MAX;
        /// Device that the application's ranges were made for, and the platform that made them, if it has any.
        expected with_expected: Option<Identity> = None;
    }
}

impl Options {
    /// Time between questions by datagram, as specified: five seconds.
    pub const ASK_EVERY: u64 = ANNOUNCE_EVERY;
}
