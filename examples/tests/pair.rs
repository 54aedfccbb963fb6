//! The example `pair`.

#[path = "../pair.rs"]
#[allow(dead_code, reason = "an example has a `main`")]
mod pair;

#[test]
fn each_request_is_paired_with_the_answer_of_its_id() {
    let mut out = Vec::new();
    pair::pairs(include_str!("../captures/dmc-move.txt"), &mut out).unwrap();
    let lines: Vec<serde_json::Value> =
        String::from_utf8(out).unwrap().lines().map(|line| line.parse().unwrap()).collect();
    let names = |side: &str| lines.iter().map(|line| line[side]["message"].as_str().unwrap()).collect::<Vec<_>>();
    assert_eq!(
        names("request"),
        [
            "Hi",
            "MotorGetPosition",
            "MotorConfigure",
            "MotorMove",
            "MotorStatus",
            "MotorStatus",
            "MotorStatus",
            "MotorGetPosition"
        ]
    );
    assert_eq!(names("answer"), ["Hi", "Ack", "Ack", "Ack", "MotorStatus", "MotorStatus", "MotorStatus", "Ack"]);
    assert_eq!(lines[3]["request"]["fields"], serde_json::json!({ "motor": 1, "position": 200 }));
    assert_eq!(lines[3]["answer"]["fields"]["response_code"], 16);
}
