//! Observations to the bit, one layout a kind ([`OBSERVATIONS`](super::layout::OBSERVATIONS)).

use super::cdr::{CdrError, CdrReader, CdrWriter};
use super::pose::{numbers2, numbers3, pose2_of, pose3_of, put_twist, twist};
use rumbo_core::boundary::Buffer;
use rumbo_core::messages::{
    Bumpers, Custom, Data, DepthImage, Imu, Intrinsics, LaserScan, Mark, Marks, Observation, ObservationKind,
    Odometry, PointCloud, PositionFix, RangeRing, SensorId, SteeringAngle, WheelSpeeds,
};
use rumbo_core::time::Time;

/// Writes an observation.
pub fn put_observation(cdr: &mut CdrWriter, observation: &Observation) {
    put_observation_head(cdr, observation);
    match &observation.data {
        Data::LaserScan(scan) => {
            cdr.f32s(&scan.ranges_m);
            cdr.f32s(&scan.intensities);
        }
        Data::PointCloud(cloud) => cdr.array32(cloud.points_m.as_flattened()),
        _ => {}
    }
}

/// Writes an observation up to the ranges or points, which viewers get in the same bytes; any other one whole.
pub fn put_observation_head(cdr: &mut CdrWriter, observation: &Observation) {
    cdr.begin().u16(observation.sensor.0);
    cdr.i64(observation.stamp.0);
    cdr.array(&numbers3(&observation.base_from_sensor));
    cdr.bool(observation.valid);
    put_data(cdr, &observation.data);
}

fn put_data(cdr: &mut CdrWriter, data: &Data) {
    match data {
        Data::Odometry(odometry) => {
            cdr.array(&numbers2(&odometry.odom_from_base));
            put_twist(cdr, &odometry.twist);
            cdr.array(&odometry.noise);
        }
        Data::WheelSpeeds(wheels) => {
            cdr.u32(wheels.n_wheels);
            cdr.array(&wheels.rim_m_s);
        }
        Data::SteeringAngle(steering) => cdr.f64(steering.angle_rad),
        Data::LaserScan(scan) => {
            cdr.array(&[scan.first_bearing_rad, scan.bearing_step_rad, scan.sweep_s]);
            cdr.f32(scan.min_range_m);
            cdr.f32(scan.max_range_m);
        }
        Data::RangeRing(ring) => {
            cdr.array(&[ring.first_bearing_rad, ring.bearing_step_rad, ring.cone_rad, ring.ring_radius_m]);
            cdr.f32(ring.min_range_m);
            cdr.f32(ring.max_range_m);
            cdr.f32s(&ring.ranges_m);
        }
        Data::Bumpers(bumpers) => {
            cdr.u32(bumpers.n_bumpers);
            cdr.u64(bumpers.pressed);
            cdr.array(&[bumpers.first_bearing_rad, bumpers.bearing_step_rad, bumpers.ring_radius_m]);
        }
        Data::DepthImage(image) => {
            let camera = &image.intrinsics;
            cdr.u32(camera.width);
            cdr.u32(camera.height);
            cdr.array(&camera.focal_px);
            cdr.array(&camera.center_px);
            cdr.f32(image.unit_m);
            cdr.u16s(&image.depth);
        }
        Data::PointCloud(cloud) => cdr.length(cloud.points_m.as_flattened().len()),
        Data::Imu(imu) => {
            cdr.f64s(imu.attitude_rad.as_ref().map_or(&[], |attitude| attitude));
            cdr.array(&imu.rates_rad_s);
            cdr.array(&imu.accelerations_m_s2);
        }
        Data::PositionFix(fix) => {
            cdr.array(&fix.position_m);
            cdr.array(&fix.deviation_m);
        }
        Data::Marks(marks) => put_marks(cdr, marks),
        Data::Custom(custom) => {
            cdr.text(&custom.schema);
            cdr.octets(&custom.bytes);
        }
        // A kind of a later core: this program could not have read it back.
        _ => {}
    }
}

fn put_marks(cdr: &mut CdrWriter, marks: &Marks) {
    cdr.array(&[marks.range_deviation_m, marks.bearing_deviation_rad]);
    cdr.length(marks.marks.len());
    for mark in &marks.marks {
        cdr.length(usize::from(mark.identity.is_some()));
        mark.identity.iter().for_each(|identity| cdr.u32(*identity));
        cdr.array(&[mark.range_m, mark.bearing_rad]);
    }
}

/// Reads an observation of this kind.
pub fn read_observation(kind: ObservationKind, message: &[u8]) -> Result<Observation, CdrError> {
    let mut cdr = CdrReader::new(message)?;
    Ok(Observation {
        sensor: SensorId(cdr.u16()?),
        stamp: Time(cdr.i64()?),
        base_from_sensor: pose3_of(cdr.array()?),
        valid: cdr.bool()?,
        data: data(kind, &mut cdr)?,
    })
}

fn data(kind: ObservationKind, cdr: &mut CdrReader<'_>) -> Result<Data, CdrError> {
    Ok(match kind {
        ObservationKind::Odometry => Data::Odometry(Odometry {
            odom_from_base: pose2_of(cdr.array()?),
            twist: twist(cdr)?,
            noise: cdr.array()?,
        }),
        ObservationKind::WheelSpeeds => {
            Data::WheelSpeeds(WheelSpeeds { n_wheels: cdr.u32()?, rim_m_s: cdr.array()? })
        }
        ObservationKind::SteeringAngle => Data::SteeringAngle(SteeringAngle { angle_rad: cdr.f64()? }),
        ObservationKind::LaserScan => Data::LaserScan(LaserScan {
            first_bearing_rad: cdr.f64()?,
            bearing_step_rad: cdr.f64()?,
            sweep_s: cdr.f64()?,
            min_range_m: cdr.f32()?,
            max_range_m: cdr.f32()?,
            ranges_m: cdr.f32s()?.as_slice().into(),
            intensities: cdr.f32s()?.as_slice().into(),
        }),
        ObservationKind::RangeRing => Data::RangeRing(RangeRing {
            first_bearing_rad: cdr.f64()?,
            bearing_step_rad: cdr.f64()?,
            cone_rad: cdr.f64()?,
            ring_radius_m: cdr.f64()?,
            min_range_m: cdr.f32()?,
            max_range_m: cdr.f32()?,
            ranges_m: cdr.f32s()?.as_slice().into(),
        }),
        ObservationKind::Bumpers => Data::Bumpers(Bumpers {
            n_bumpers: cdr.u32()?,
            pressed: cdr.u64()?,
            first_bearing_rad: cdr.f64()?,
            bearing_step_rad: cdr.f64()?,
            ring_radius_m: cdr.f64()?,
        }),
        ObservationKind::DepthImage => Data::DepthImage(DepthImage {
            intrinsics: Intrinsics {
                width: cdr.u32()?,
                height: cdr.u32()?,
                focal_px: cdr.array()?,
                center_px: cdr.array()?,
            },
            unit_m: cdr.f32()?,
            depth: cdr.u16s()?.as_slice().into(),
        }),
        ObservationKind::PointCloud => Data::PointCloud(PointCloud { points_m: points(&cdr.f32s()?) }),
        ObservationKind::Imu => Data::Imu(Imu {
            attitude_rad: cdr.f64s()?.try_into().ok(),
            rates_rad_s: cdr.array()?,
            accelerations_m_s2: cdr.array()?,
        }),
        ObservationKind::PositionFix => {
            Data::PositionFix(PositionFix { position_m: cdr.array()?, deviation_m: cdr.array()? })
        }
        ObservationKind::Marks => Data::Marks(marks(cdr)?),
        ObservationKind::Custom => {
            Data::Custom(Custom { schema: cdr.text()?, bytes: Buffer::from(cdr.octets()?) })
        }
        other => {
            let found = other.name().to_owned();
            return Err(CdrError::Value { field: "kind", found, expected: "a kind that this program knows" });
        }
    })
}

fn points(flat: &[f32]) -> Buffer<[f32; 3]> {
    let (points, _) = flat.as_chunks::<3>();
    points.into()
}

fn marks(cdr: &mut CdrReader<'_>) -> Result<Marks, CdrError> {
    let [range_deviation_m, bearing_deviation_rad] = cdr.array()?;
    let n_marks = cdr.length(4)?;
    let mark = |cdr: &mut CdrReader<'_>| {
        let identity = if cdr.length(4)? > 0 { Some(cdr.u32()?) } else { None };
        let [range_m, bearing_rad] = cdr.array()?;
        Ok(Mark { identity, range_m, bearing_rad })
    };
    let marks = (0..n_marks).map(|_| mark(cdr)).collect::<Result<_, CdrError>>()?;
    Ok(Marks { marks, range_deviation_m, bearing_deviation_rad })
}

#[cfg(test)]
mod tests {
    use super::super::difference::first_difference;
    use super::super::layout::{OBSERVATIONS, observation_kind};
    use super::*;
    use rumbo_core::frames::pose2;

    /// One observation a kind, with numbers that no rounding survives.
    fn all() -> Vec<Data> {
        let third = 1.0 / 3.0;
        let ranges: Buffer<f32> = [0.1f32, f32::INFINITY, f32::NAN].as_slice().into();
        let camera = Intrinsics { width: 2, height: 1, focal_px: [third, 2.0], center_px: [0.5, third] };
        let mark = Mark { identity: Some(7), range_m: third, bearing_rad: -third };
        vec![
            Data::Odometry(Odometry { odom_from_base: pose2(third, 2.0, third), ..Odometry::default() }),
            Data::WheelSpeeds(WheelSpeeds { n_wheels: 2, rim_m_s: [third, -third, 0.0, -0.0] }),
            Data::SteeringAngle(SteeringAngle { angle_rad: third }),
            Data::LaserScan(LaserScan {
                first_bearing_rad: -third,
                max_range_m: 8.0,
                ranges_m: ranges.clone(),
                intensities: ranges.clone(),
                ..LaserScan::default()
            }),
            Data::RangeRing(RangeRing { cone_rad: third, ranges_m: ranges, ..RangeRing::default() }),
            Data::Bumpers(Bumpers { n_bumpers: 3, pressed: 1 << 63, ..Bumpers::default() }),
            Data::DepthImage(DepthImage {
                intrinsics: camera,
                unit_m: 0.001,
                depth: [3u16, 65535].as_slice().into(),
            }),
            Data::PointCloud(PointCloud { points_m: [[1.0, f32::NAN, 3.0]].as_slice().into() }),
            Data::Imu(Imu { attitude_rad: Some([third, 0.0, 1.0]), ..Imu::default() }),
            Data::PositionFix(PositionFix { position_m: [third; 3], deviation_m: [1.0; 3] }),
            Data::Marks(Marks { marks: vec![mark, Mark::default()], ..Marks::default() }),
            Data::Custom(Custom { schema: "a/B".into(), bytes: [1u8, 2].as_slice().into() }),
        ]
    }

    #[test]
    fn every_kind_of_observation_comes_back_to_the_bit_and_fits_its_layout() {
        let (mut cdr, mut again) = (CdrWriter::default(), CdrWriter::default());
        let kinds: Vec<ObservationKind> = all().iter().map(Data::kind).collect();
        assert_eq!(kinds, OBSERVATIONS.map(|(kind, _)| kind));
        for (data, (kind, layout)) in all().into_iter().zip(OBSERVATIONS) {
            let base_from_sensor = pose3_of([0.1, 0.2, 0.3, 0.5, -0.5, 0.5, 0.5]);
            let observation =
                Observation { sensor: SensorId(3), stamp: Time(-5), base_from_sensor, valid: false, data };
            put_observation(&mut cdr, &observation);
            let back = read_observation(kind, cdr.bytes()).unwrap();
            put_observation(&mut again, &back);
            assert_eq!(again.bytes(), cdr.bytes(), "{kind:?}");
            assert_eq!((back.sensor, back.stamp, back.valid), (SensorId(3), Time(-5), false));
            assert_eq!(observation_kind(layout.name), Some(kind));
            // The walk along the layout finds the last field: nothing is left over or missing.
            let mut other = cdr.bytes().to_vec();
            *other.last_mut().unwrap() ^= 1;
            let found = first_difference(&layout, cdr.bytes(), &other).unwrap();
            assert_ne!(found.field, "bytes", "{kind:?}");
            for len in 0..cdr.bytes().len() {
                assert!(read_observation(kind, &cdr.bytes()[..len]).is_err(), "{kind:?} cut at {len}");
            }
        }
    }
}
