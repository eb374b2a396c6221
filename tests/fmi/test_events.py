"""Events: status and times latch, FMI 3.0's event mode and early return, and stopping on request."""

import unittest

from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated
from host import DISCARD, OK, SMALL, Host

H = 1e-6
EXITED = 4


class Events(unittest.TestCase):
    def expected(self):
        """Times of first contact and exit in a run without events."""
        host = Host(2, SMALL).run(0, 200, H)
        self.assertEqual(host.get("status"), EXITED)
        times = host.get("time_first_contact"), host.get("time_event")
        work = host.get("contact.work")
        host.close()
        return times, work

    def test_event_mode_returns_early_at_the_tick(self):
        (contact, event), work = self.expected()
        host, t, events = Host(3, SMALL, events=True), 0.0, []
        while t < 200 * H - 1e-12:
            self.assertEqual(host.step(t, min(H, 200 * H - t)), OK)
            needed, stop, early, reached = host.last
            self.assertFalse(stop)
            self.assertTrue(needed or not early)
            t = reached
            if needed:
                events.append(t)
                host.fmu.enterEventMode()
                host.fmu.updateDiscreteStates()
                host.fmu.enterStepMode()
        self.assertAlmostEqual(events[0], contact, delta=2.1e-8)
        self.assertTrue(any(abs(t - event) < 2.1e-8 for t in events), events)
        self.assertEqual(host.get("time_event"), event)
        self.assertEqual(host.get("contact.work"), work)
        host.close()

    def test_step_mode_never_returns_early(self):
        (_, event), _ = self.expected()
        host = Host(3, SMALL)
        for k in range(200):
            self.assertEqual(host.step(k * H, H), OK)
            self.assertEqual(host.last[:3], (False, False, False))
        self.assertEqual(host.get("time_event"), event)
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
        host = Host(3, SMALL).run(0, 5, H)
        self.assertEqual(host.log, [])
        host.close()


if __name__ == "__main__":
    unittest.main()
