// The controller from Rust: the structs are `repr(C)`.
//
//   gsp export @nano-hexapod --to c --mode 8 -o nano_hexapod.c
//   cc -std=c99 -O2 -c nano_hexapod.c && ar rcs libnano_hexapod.a nano_hexapod.o
//   rustc --edition 2021 -O follow.rs -L . -l static=nano_hexapod && ./follow
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Pose {
    pub position: [f64; 3],
    pub rotation: [f64; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    pub pose: Pose,
    pub values: [f64; 6],
    pub error: f64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    pub fraction: f64,
    pub sigma: f64,
    pub alone: f64,
    pub steps: i32,
    pub tries: i32,
}

extern "C" {
    fn nano_hexapod_inverse(pose: *const Pose, values: *mut f64) -> i32;
    fn nano_hexapod_start(pose: *const Pose, state: *mut State, report: *mut Report) -> i32;
    fn nano_hexapod_forward(values: *const f64, state: *mut State, report: *mut Report) -> i32;
}

/// The continuation of a pose along the straight line of values, or the status of the refusal.
pub fn forward(state: &mut State, values: &[f64; 6]) -> Result<Report, i32> {
    let mut report = Report::default();
    match unsafe { nano_hexapod_forward(values.as_ptr(), state, &mut report) } {
        0 => Ok(report),
        status => Err(status),
    }
}

fn main() {
    let mut pose = Pose { position: [0.0, 0.0, 0.09], rotation: [1.0, 0.0, 0.0, 0.0] };
    let mut state = State::default();
    let mut report = Report::default();
    assert_eq!(unsafe { nano_hexapod_start(&pose, &mut state, &mut report) }, 0);
    assert!(report.alone > 0.0, "too near to a singular pose");
    for cycle in 1..=100 {
        pose.position[2] = 0.09 + 1e-5 * f64::from(cycle);
        let mut values = [0.0; 6];
        assert_eq!(unsafe { nano_hexapod_inverse(&pose, values.as_mut_ptr()) }, 0);
        if let Err(status) = forward(&mut state, &values) {
            panic!("cycle {cycle}: refused ({status})");
        }
    }
    assert!((state.pose.position[2] - 0.091).abs() <= state.error + 1e-15);
    println!("lifted to z = {:.6} m, exact within {:.0e} m", state.pose.position[2], state.error);
}
