//! Why an observation was not taken: a value to count, apart from errors that end a run.

/// Why the mapper did not take an observation; the map stays as it was.
///
/// ```
/// let refused = limpid::Refused::TooManyPoints { points: 300_000, most: 262_144 };
/// assert_eq!(refused.to_string(), "300000 points; the mapper is built for 262144 (`max_points`)");
/// ```
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refused {
    /// Nothing says where the sensor was.
    #[error("no transform from map to sensor")]
    NoPose,
    /// The pose has a NaN or an infinity.
    #[error("the pose is not finite")]
    PoseNotFinite,
    /// The observation is of a sensor, or of a kind of sensor, that the mapper was not built for.
    #[error("the mapper was not built for it: {0}")]
    Sensor(String),
    /// An image's size, encoding or number of samples is not what the mapper was built for.
    #[error("{what} image: {reason}")]
    Image {
        /// Depth, colour or confidence.
        what: &'static str,
        /// What was expected and what came.
        reason: String,
    },
    /// A calibration that the mapper cannot go on with.
    #[error("{what} calibration: {reason}")]
    Calibration {
        /// Depth or colour.
        what: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// A scan has more points than the mapper was built for.
    #[error("{points} points; the mapper is built for {most} (`max_points`)")]
    TooManyPoints {
        /// Of the scan.
        points: usize,
        /// Of the mapper.
        most: usize,
    },
    /// The stamp lies far ahead of those of all other sensors.
    #[error("the stamp is {ahead_s} s ahead of the other sensors'")]
    Ahead {
        /// Whole seconds.
        ahead_s: u64,
    },
}
