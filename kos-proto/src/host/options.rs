//! What a client machine can be told once, at its begin.

use crate::discovery::ANNOUNCE_EVERY;
use crate::summary::{debug_fields, with};

/// How a client behaves. Times are in milliseconds.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Options {
    /// Time between questions by datagram while nobody is connected, from the first step on; `None`, for devices
    /// announce themselves.
    pub ask_every: Option<u64>,
    /// Time in which a question is answered: 3000.
    pub request_timeout: u64,
    /// Time without a message, sent or received, after which the line over TCP is kept alive: 10 000, as specified.
    pub tcp_keep_alive: u64,
    /// Time between keep-alives over USB: 4000, as specified.
    pub usb_keep_alive: u64,
    /// Silence of the device after which the connection over TCP is given up: 25 000, two unanswered keep-alives.
    pub silence: u64,
    /// Time in which a stop is confirmed, before it is sent again: 2000.
    pub stop_timeout: u64,
    /// Time after which a move that is not ready, or does not begin, and a motor that does not rest, are worth a
    /// remark: two minutes, for the way may be long.
    pub setup_timeout: u64,
    /// Time between two commands to one motor: 50, twenty a second, as is known to be borne.
    pub motor_interval: u64,
    /// Time in which the application has to say something while it jogs a motor, before the motor is stopped: 1000.
    pub dead_man: u64,
    /// Whether the password that the device tells is sent back; yes, as the public client does. Otherwise the
    /// application has one.
    pub echo_password: bool,
    /// Whether a connection that is lost is tried again; yes.
    pub reconnect: bool,
    /// Time before the first try to connect again: 1000. It doubles with each, up to 32 times.
    pub back_off: u64,
    /// The device that the application's ranges were made for, and the platform that made them, if it has any.
    pub expected: Option<Identity>,
}

/// Which device it is, and which platform calibrated its motors (safety decision 9).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Identity {
    /// Its number.
    pub guid: [u8; 16],
    /// The platform.
    pub platform: u8,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            ask_every: None,
            request_timeout: 3000,
            tcp_keep_alive: 10_000,
            usb_keep_alive: 4000,
            silence: 25_000,
            stop_timeout: 2000,
            setup_timeout: 120_000,
            motor_interval: 50,
            dead_man: 1000,
            echo_password: true,
            reconnect: true,
            back_off: 1000,
            expected: None,
        }
    }
}

impl Options {
    /// Time between questions that [`with_ask_every`](Self::with_ask_every) may be given: five seconds, as specified.
    pub const ASK_EVERY: u64 = ANNOUNCE_EVERY;

    with! {
        /// With questions by datagram, so often.
        with_ask_every ask_every: Option<u64>;
        /// With this time for answers.
        with_request_timeout request_timeout: u64;
        /// With this time before a keep-alive over TCP.
        with_tcp_keep_alive tcp_keep_alive: u64;
        /// With this time between keep-alives over USB.
        with_usb_keep_alive usb_keep_alive: u64;
        /// With this silence.
        with_silence silence: u64;
        /// With this time for a stop to be confirmed.
        with_stop_timeout stop_timeout: u64;
        /// With this time for a move to be ready.
        with_setup_timeout setup_timeout: u64;
        /// With this time between two commands to a motor.
        with_motor_interval motor_interval: u64;
        /// With this time for the application to say something.
        with_dead_man dead_man: u64;
        /// With the password of the device, or of the application.
        with_echo_password echo_password: bool;
        /// With or without another try.
        with_reconnect reconnect: bool;
        /// With this time before the first of them.
        with_back_off back_off: u64;
        /// With this device and platform.
        with_expected expected: Option<Identity>;
    }
}

debug_fields! {
    Options {
        ask_every,
        request_timeout,
        tcp_keep_alive,
        usb_keep_alive,
        silence,
        stop_timeout,
        setup_timeout,
        motor_interval,
        dead_man,
        echo_password,
        reconnect,
        back_off,
        expected,
    }
}
