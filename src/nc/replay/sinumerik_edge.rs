//! The cutting edge of a SINUMERIK's tool, as a program writes it: position, radius and wear.

use super::interpreter::Interpreter;
use super::sinumerik::parsed;

impl Interpreter<'_> {
    /// `6[1,1]=0.4` after `$TC_DP`: position (2), radius (6) or wear of the radius (15) of a tool's
    /// first edge, which act from the next call of the tool on.
    pub(super) fn write_edge(&mut self, rest: &str) -> Result<(), String> {
        let unknown = || format!("$TC_DP{rest} is not understood");
        let (place, value) = rest.split_once('=').ok_or_else(unknown)?;
        let (parameter, edge) = place.split_once('[').ok_or_else(unknown)?;
        let (tool, edge) = edge.strip_suffix(']').and_then(|e| e.split_once(',')).ok_or_else(unknown)?;
        let (tool, edge) = (parsed(tool)?, parsed(edge)?);
        if tool != f64::from(self.control.settings.tool) || edge != 1.0 {
            return Err(format!(
                "an edge is written that is not the first one of tool {}",
                self.control.settings.tool
            ));
        }
        if self.modal.tool_called {
            return Err(
                "an edge is written after its tool was called: it would act from the next call on".into()
            );
        }
        let value = parsed(value)?;
        let register = self.nose.registers.entry(tool as u32).or_default();
        match parameter {
            "2" if value.fract() == 0.0 && (1.0..=9.0).contains(&value) => register.tip = value as u8,
            "6" if value >= 0.0 => register.radius = value,
            "15" => register.wear = value,
            _ => return Err(unknown()),
        }
        Ok(())
    }
}
