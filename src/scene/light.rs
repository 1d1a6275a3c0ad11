//! Which lights are there when an option, or nobody, names them?

use super::{Bounds, Environment, MAX_VALUE};
use crate::error::{SceneError, shortened};
use glam::{DVec3, Vec3};
use twinlight_kernels::passes::scene::{LIGHT_POINT, LIGHT_SPOT, LIGHT_SUN, Light};

const POINT_FORM: &str = "x,y,z:R,G,B (metres : W/sr)";
const SPOT_FORM: &str =
    "x,y,z:dx,dy,dz:R,G,B:OUTER[,INNER] (metres : direction : W/sr : half angles in degrees)";
const SUN_FORM: &str = "dx,dy,dz:R,G,B (the way light travels : W/m² on a surface facing it)";
const SPHERE_FORM: &str = "x,y,z:RADIUS[:R,G,B] (metres : metres : albedo)";
const DAYLIGHT_FORM: &str = "x,y,z[:TURBIDITY] (toward the sun : 2 to 10)";
const SKY_FORM: &str = "R,G,B (radiance in W/(m² sr))";

/// Returns a point light of radiant intensity `intensity` in W/sr at `position` in metres.
pub fn point(position: Vec3, intensity: Vec3) -> Light {
    Light {
        position: position.extend(0.0),
        direction: Vec3::NEG_Y.extend(0.0),
        intensity: intensity.extend(0.0),
        kind: LIGHT_POINT,
        ..Light::default()
    }
}

/// Returns a spot light along the unit vector `direction`, with half angles in radians, `inner` ≤ `outer`.
pub fn spot(position: Vec3, direction: Vec3, intensity: Vec3, inner: f32, outer: f32) -> Light {
    let direction = direction.extend(0.0);
    Light { direction, kind: LIGHT_SPOT, inner, outer, ..point(position, intensity) }
}

/// Returns parallel light that travels along the unit vector `direction`, of `irradiance` in W/m².
pub fn sun(direction: Vec3, irradiance: Vec3) -> Light {
    Light { direction: direction.extend(0.0), kind: LIGHT_SUN, ..point(Vec3::ZERO, irradiance) }
}

/// Returns the light for a scene without any: a white point light above the centre of the box.
///
/// It hangs 40 % of the height (in flat scenes a quarter of the width) above the centre, and its intensity of
/// π·d² W/sr (d at most 5e8 m) gives a surface at the centre that faces it π W/m²: a white Lambert surface there has radiance 1.
pub fn default_light(bounds: &Bounds) -> Light {
    let size = bounds.size();
    let widest = size.x.max(size.z);
    let above = if size.y > 0.05 * widest { 0.4 * size.y } else { 0.25 * widest };
    let above = above.clamp(1.0e-6, 5.0e8);
    let intensity = (std::f64::consts::PI * f64::from(above) * f64::from(above)) as f32;
    point(bounds.centre() + Vec3::Y * above, Vec3::splat(intensity))
}

/// Reads `--point x,y,z:R,G,B`.
///
/// # Errors
/// Another form, numbers that are not finite, negative intensities.
pub fn parse_point(text: &str) -> Result<Light, SceneError> {
    let reader = Reader { option: "--point", text, expected: POINT_FORM };
    let [position, intensity] = reader.groups()?;
    Ok(point(reader.vector(position)?, reader.colour(intensity)?))
}

/// Reads `--spot x,y,z:dx,dy,dz:R,G,B:OUTER[,INNER]`; without INNER the edge is sharp at OUTER.
///
/// # Errors
/// Another form, numbers that are not finite, a direction of length 0, negative intensities, angles outside
/// 0 ≤ INNER ≤ OUTER, 0 < OUTER ≤ 180.
pub fn parse_spot(text: &str) -> Result<Light, SceneError> {
    let reader = Reader { option: "--spot", text, expected: SPOT_FORM };
    let [position, direction, intensity, cone] = reader.groups()?;
    let (outer, inner) = match reader.numbers(cone)?.as_slice() {
        &[outer] => (outer, outer),
        &[outer, inner] => (outer, inner),
        other => return reader.fail(format!("{} angles where 1 or 2 belong", other.len())),
    };
    if !(outer > 0.0 && outer <= 180.0 && inner >= 0.0 && inner <= outer) {
        return reader.fail("the angles are not 0 <= INNER <= OUTER <= 180 with OUTER above 0".into());
    }
    let direction = reader.direction(direction)?;
    let (inner, outer) = (inner.to_radians(), outer.to_radians());
    Ok(spot(reader.vector(position)?, direction, reader.colour(intensity)?, inner, outer))
}

/// Reads `--sun dx,dy,dz:R,G,B`.
///
/// # Errors
/// Another form, numbers that are not finite, a direction of length 0, negative irradiance.
pub fn parse_sun(text: &str) -> Result<Light, SceneError> {
    let reader = Reader { option: "--sun", text, expected: SUN_FORM };
    let [direction, irradiance] = reader.groups()?;
    Ok(sun(reader.direction(direction)?, reader.colour(irradiance)?))
}

/// Reads `--sky R,G,B`.
///
/// # Errors
/// Another form, numbers that are not finite, negative radiance.
pub fn parse_sky(text: &str) -> Result<Environment, SceneError> {
    let reader = Reader { option: "--sky", text, expected: SKY_FORM };
    let [radiance] = reader.groups()?;
    Ok(Environment::Constant(reader.colour(radiance)?))
}

/// Reads `--daylight x,y,z[:TURBIDITY]`: the sky of a clear day with the sun in that direction; turbidity 3 if none is given.
///
/// # Errors
/// Another form, a sun below the horizon, a turbidity outside 2 to 10.
pub fn parse_daylight(text: &str) -> Result<Environment, SceneError> {
    let reader = Reader { option: "--daylight", text, expected: DAYLIGHT_FORM };
    let (sun, turbidity) = match text.split_once(':') {
        Some((sun, turbidity)) => (sun, reader.numbers(turbidity)?),
        None => (text, vec![3.0]),
    };
    let &[turbidity] = turbidity.as_slice() else { return reader.fail("one turbidity belongs there".into()) };
    super::daylight(reader.direction(sun)?, turbidity).or_else(|reason| reader.fail(reason))
}

/// Reads `--sphere x,y,z:RADIUS[:R,G,B]`: centre, radius above 0, and an albedo in [0, 1].
///
/// # Errors
/// Another form, numbers that are not finite or out of range.
pub fn parse_sphere(text: &str) -> Result<(Vec3, f32, Option<Vec3>), SceneError> {
    let reader = Reader { option: "--sphere", text, expected: SPHERE_FORM };
    let (body, albedo) = match text.match_indices(':').nth(1) {
        Some((at, _)) => (&text[..at], Some(reader.colour(&text[at + 1..])?)),
        None => (text, None),
    };
    let [centre, radius] = Reader { text: body, ..reader }.groups()?;
    let radius = match reader.numbers(radius)?.as_slice() {
        &[radius] if radius > 0.0 => radius,
        _ => return reader.fail("the radius is not one number above 0".into()),
    };
    if albedo.is_some_and(|a| a.max_element() > 1.0) {
        return reader.fail("the albedo is above 1".into());
    }
    Ok((reader.vector(centre)?, radius, albedo))
}

/// Reads three numbers `x,y,z` of an option such as `--eye`.
///
/// # Errors
/// Another form, numbers that are not finite.
pub fn parse_vector(option: &'static str, text: &str) -> Result<Vec3, SceneError> {
    Reader { option, text, expected: "x,y,z" }.vector(text)
}

/// An option's text, for messages.
#[derive(Clone, Copy)]
struct Reader<'a> {
    option: &'static str,
    text: &'a str,
    expected: &'static str,
}

impl<'a> Reader<'a> {
    fn fail<T>(&self, reason: String) -> Result<T, SceneError> {
        let text = shortened(self.text, 50);
        Err(SceneError::Text { option: self.option, text, reason, expected: self.expected })
    }

    fn groups<const N: usize>(&self) -> Result<[&'a str; N], SceneError> {
        let groups: Vec<&str> = self.text.split(':').collect();
        match <[&str; N]>::try_from(groups.as_slice()) {
            Ok(groups) => Ok(groups),
            Err(_) => self.fail(format!("{} groups between colons where {N} belong", groups.len())),
        }
    }

    fn numbers(&self, group: &str) -> Result<Vec<f32>, SceneError> {
        group
            .split(',')
            .map(|word| match word.trim().parse::<f32>() {
                Ok(number) if number.abs() <= MAX_VALUE => Ok(number),
                Ok(number) if number.is_finite() => self.fail(format!("{number:e} is beyond {MAX_VALUE:e}")),
                Ok(_) => self.fail(format!("{:?} is not a finite number", shortened(word.trim(), 50))),
                Err(_) => self.fail(format!("{:?} is not a number", shortened(word.trim(), 50))),
            })
            .collect()
    }

    fn vector(&self, group: &str) -> Result<Vec3, SceneError> {
        match self.numbers(group)?.as_slice() {
            &[x, y, z] => Ok(Vec3::new(x, y, z)),
            other => {
                self.fail(format!("{} numbers in {:?} where 3 belong", other.len(), shortened(group, 50)))
            }
        }
    }

    fn colour(&self, group: &str) -> Result<Vec3, SceneError> {
        let colour = self.vector(group)?;
        if colour.min_element() < 0.0 {
            return self.fail(format!("{:?} is negative", shortened(group, 50)));
        }
        Ok(colour)
    }

    fn direction(&self, group: &str) -> Result<Vec3, SceneError> {
        let vector: DVec3 = self.vector(group)?.as_dvec3();
        match vector.try_normalize() {
            Some(unit) => Ok(unit.as_vec3()),
            None => self.fail(format!("the direction {:?} has length 0", shortened(group, 50))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forms_of_the_command_line_are_read() {
        let light = parse_point("0, 1.8,0:2,2.5,3e0").unwrap();
        assert_eq!((light.kind, light.position.y, light.intensity.y), (LIGHT_POINT, 1.8, 2.5));
        let light = parse_spot("1,2,3:0,-2,0:4,4,4:35").unwrap();
        assert_eq!((light.kind, light.direction.y, light.inner), (LIGHT_SPOT, -1.0, light.outer));
        let light = parse_spot("1,2,3:0,-2,0:4,4,4:90,45").unwrap();
        assert_eq!((light.outer, light.inner), (90f32.to_radians(), 45f32.to_radians()));
        let light = parse_sun("3,0,4:1,1,1").unwrap();
        assert_eq!((light.kind, light.direction.x, light.direction.z), (LIGHT_SUN, 0.6, 0.8));
        assert_eq!(parse_sky("0.5,0,1").unwrap(), Environment::Constant(Vec3::new(0.5, 0.0, 1.0)));
        assert_eq!(parse_sphere("1,2,3:0.5").unwrap(), (Vec3::new(1.0, 2.0, 3.0), 0.5, None));
        let coloured = parse_sphere("1,2,3:0.5:0.1,0.2,1").unwrap();
        assert_eq!(coloured.2, Some(Vec3::new(0.1, 0.2, 1.0)));
        assert_eq!(parse_vector("--eye", "1,2,3").unwrap(), Vec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn wrong_text_names_the_form() {
        let cases = [
            (parse_point("").map(drop), "1 groups"),
            (parse_point("1,2,3").map(drop), "1 groups"),
            (parse_point("1,2:1,1,1").map(drop), "2 numbers"),
            (parse_point("1,2,x:1,1,1").map(drop), "\"x\" is not a number"),
            (parse_point("1,2,inf:1,1,1").map(drop), "finite"),
            (parse_point("1,2,3:1,-1,1").map(drop), "negative"),
            (parse_spot("1,2,3:0,0,0:4,4,4:35").map(drop), "length 0"),
            (parse_spot("1,2,3:0,1,0:4,4,4:35,36").map(drop), "angles"),
            (parse_spot("1,2,3:0,1,0:4,4,4:1,1,1").map(drop), "3 angles"),
            (parse_sun("0,0,0:1,1,1").map(drop), "length 0"),
            (parse_sky("1,1,1,1").map(drop), "4 numbers"),
            (parse_sky("1,1,1:2").map(drop), "2 groups"),
            (parse_daylight("0,-1,0").map(drop), "horizon"),
            (parse_daylight("0,1,0:20").map(drop), "turbidity"),
            (parse_daylight("0,1,0:2,3").map(drop), "one turbidity"),
            (parse_sphere("1,1,1").map(drop), "1 groups"),
            (parse_sphere("1,1,1:0").map(drop), "above 0"),
            (parse_sphere("1,1,1:1,2").map(drop), "above 0"),
            (parse_sphere("1,1,1:1:2,0,0").map(drop), "above 1"),
            (parse_sphere("1,1,1:1:0,0,0:1").map(drop), "not a number"),
        ];
        for (result, word) in cases {
            let message = result.unwrap_err().to_string();
            assert!(message.contains(word) && message.contains("the form is"), "{message} lacks {word}");
            assert!(!message.contains('\n'));
        }
    }

    #[test]
    fn the_default_light_gives_the_centre_pi() {
        for max in [Vec3::splat(2.0), Vec3::new(10.0, 0.0, 4.0)] {
            let bounds = Bounds { min: Vec3::ZERO, max };
            let light = default_light(&bounds);
            let d = light.position.y - bounds.centre().y;
            assert!((light.intensity.x / (d * d) - std::f32::consts::PI).abs() < 1e-5);
        }
        assert!(default_light(&Bounds::EMPTY).intensity.is_finite());
    }
}
