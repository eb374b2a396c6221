"""Events: status and times latch, FMI 3.0's event mode and early return, and stopping on request."""

import unittest

from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated
from host import DISCARD, OK, SMALL, Host

H = 1e-6
TICK = 2e-8
ARRESTED, EXITED = 2, 4
# What happens: the values, the outcome, and the number of steps to some time after it.
CASES = [(SMALL, EXITED, 200), ({**SMALL, "projectile.velocity": [0.0, 0.0, 20.0]}, ARRESTED, 250)]


class Events(unittest.TestCase):
    def expected(self, values, outcome, steps):
        """Times of first contact and outcome, and all outputs, in a run of FMI 2.0, which knows no events."""
        host = Host(2, values).run(0, steps, H)
        self.assertEqual(host.get("status"), outcome)
        outputs = host.outputs()
        host.close()
        return outputs["time_first_contact"], outputs["time_event"], outputs

    def test_event_mode_returns_early_at_the_tick(self):
        for values, outcome, steps in CASES:
            contact, event, outputs = self.expected(values, outcome, steps)
            host, t, events = Host(3, values, events=True), 0.0, []
            while t < steps * H - 1e-12:
                self.assertEqual(host.step(t, min(H, steps * H - t)), OK)
                needed, stop, early, reached = host.last
                self.assertFalse(stop)
                self.assertTrue(needed or not early)
                t = reached
                if needed:
                    events.append(t)
                    host.fmu.enterEventMode()
                    host.fmu.updateDiscreteStates()
                    host.fmu.enterStepMode()
            self.assertAlmostEqual(events[0], contact, delta=1.05 * TICK)
            self.assertTrue(any(abs(t - event) < 1.05 * TICK for t in events), events)
            # The physics goes on as if nobody had looked; only the two step means depend on the steps.
            for name, value in host.outputs().items():
                if not name.endswith("_mean"):
                    self.assertEqual(value, outputs[name], name)
            host.close()

    def test_events_without_early_return(self):
        """Event mode used, early return not allowed: the step ends where the host said, and the event is told then."""
        contact, event, _ = self.expected(*CASES[0])
        host = Host(3, SMALL, events=True, early=False)
        told = []
        for k in range(200):
            self.assertEqual(host.step(k * H, H), OK)
            needed, _, early, reached = host.last
            self.assertFalse(early)
            self.assertAlmostEqual(reached, (k + 1) * H, delta=1e-15)
            if needed:
                told.append(reached)
        self.assertTrue(contact <= told[0] < contact + H, told)
        self.assertTrue(event <= told[-1] < event + H, told)
        self.assertEqual(host.get("time_event"), event)
        host.close()

    def test_step_mode_never_returns_early(self):
        for values, outcome, steps in CASES:
            _, event, outputs = self.expected(values, outcome, steps)
            host = Host(3, values)
            for k in range(steps):
                self.assertEqual(host.step(k * H, H), OK)
                self.assertEqual(host.last[:3], (False, False, False))
            self.assertEqual(host.outputs(), outputs)
            host.close()

    def test_stop_on_event(self):
        host = Host(2, {**SMALL, "stop_on_event": True})
        for k in range(200):
            status = host.step(k * H, H)
            if status != OK:
                break
        self.assertEqual(status, DISCARD)
        self.assertTrue(host.fmu.getBooleanStatus(fmi2Terminated))
        self.assertAlmostEqual(host.fmu.getRealStatus(fmi2LastSuccessfulTime), host.get("time_event"), delta=1e-12)
        host.close()
        host = Host(3, {**SMALL, "stop_on_event": True})
        for k in range(200):
            self.assertEqual(host.step(k * H, H), OK)
            if host.last[1]:
                break
        self.assertTrue(host.last[1])
        host.close()

    def test_events_are_logged_on_request(self):
        host = Host(3, {**SMALL, "log.level": 3}, logging_on=True).run(0, 5, H)
        self.assertTrue(host.said("first contact at internal step"))
        host.close()
        host = Host(3, SMALL, logging_on=False).run(0, 5, H)
        self.assertEqual(host.log, [])
        host.close()


if __name__ == "__main__":
    unittest.main()
