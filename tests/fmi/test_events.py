"""Events: outcomes latch with their times beside the status, FMI 3.0's event mode and early return, and stopping on request."""

import fmpy
from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated
from host import ARCHIVES, DISCARD, OK, OUTPUTS, SMALL, Host

H = 1e-6
TICK = 2e-8
# What happens: the values, the outcome, and the number of steps to some time after it.
CASES = [(SMALL, "exited", 200), ({**SMALL, "projectile.start.velocity[3]": 20.0}, "arrested", 250)]
DISCRETE = ["status", *(name for name in OUTPUTS if name.startswith("outcome."))]
ENDING = [f"outcome.{name}" for name in ("arrested", "detached", "exited", "passed")]
OUTCOMES = [name for name in DISCRETE[1:] if not name.endswith("_time")]


def expected(values, outcome, steps):
    """Times of first contact and outcome, and all outputs, in a run of FMI 2.0, which knows no events."""
    host = Host(2, values).run(0, steps, H)
    assert host.get(f"outcome.{outcome}")
    outputs = host.outputs()
    return outputs["outcome.first_contact_time"], outputs[f"outcome.{outcome}_time"], outputs


def test_event_mode_returns_early_at_the_tick():
    for values, outcome, steps in CASES:
        contact, event, outputs = expected(values, outcome, steps)
        host, t, events = Host(3, values, events=True), 0.0, []
        while t < steps * H - 1e-12:
            assert host.step(t, min(H, steps * H - t)) == OK
            needed, stop, early, reached = host.last
            assert not stop
            assert needed or not early
            t = reached
            if needed:
                events.append(t)
                host.fmu.enterEventMode()
                host.fmu.updateDiscreteStates()
                host.fmu.enterStepMode()
        assert abs(events[0] - contact) <= 1.05 * TICK
        assert any(abs(t - event) < 1.05 * TICK for t in events), events
        host.fmu.enterEventMode()
        # The physics goes on as if nobody had looked; only the two step means depend on the steps.
        for name, value in host.outputs().items():
            if not name.endswith("_mean"):
                assert value == outputs[name], name


def test_events_without_early_return():
    """Event mode used, early return not allowed: the step ends where the host said, and the event is told then."""
    contact, event, _ = expected(*CASES[0])
    host = Host(3, SMALL, events=True, early=False)
    told = []
    for k in range(200):
        assert host.step(k * H, H) == OK
        needed, _, early, reached = host.last
        assert not early
        assert abs(reached - (k + 1) * H) <= 1e-15
        if needed:
            told.append(reached)
            host.fmu.enterEventMode()
            host.fmu.updateDiscreteStates()
            host.fmu.enterStepMode()
    assert contact <= told[0] < contact + H, told
    assert any(event <= t < event + H for t in told), told
    assert host.get("outcome.exited_time") == event


def test_discrete_variables_change_in_event_mode_only():
    """Read after every call: what the description calls discrete changes on entering event mode, which the step has asked
    for."""
    declared = [v.name for v in Host(3).variables.values() if v.variability == "discrete"]
    assert sorted(declared) == sorted(DISCRETE)
    for early in (False, True):
        host, t, changes = Host(3, SMALL, events=True, early=early), 0.0, 0
        shown = [host.get(name) for name in DISCRETE]
        while t < 2e-4 - 1e-12:
            assert host.step(t, min(H, 2e-4 - t)) == OK
            needed, _, _, t = host.last
            assert [host.get(name) for name in DISCRETE] == shown
            for name in OUTCOMES:
                assert (host.get(f"{name}_time") > 0.0) == host.get(name), name
            if needed:
                host.fmu.enterEventMode()
                now = [host.get(name) for name in DISCRETE]
                assert now != shown
                host.fmu.updateDiscreteStates()
                assert [host.get(name) for name in DISCRETE] == now
                host.fmu.enterStepMode()
                shown, changes = now, changes + 1
        assert changes > 2


def test_the_status_is_what_is_true_now():
    """A sphere that was stopped still touches the sheet, then flies back: the outcome stays, the status does not."""
    host, seen = Host(2, CASES[1][0]), []
    for k in range(500):
        host.run(k, k + 1, H)
        touching = any(host.get("contact.force_mean"))
        if host.get("outcome.arrested"):
            seen.append((host.get("status"), touching))
    assert (1, True) in seen
    assert (0, False) in seen
    assert (1, False) not in seen
    assert not host.get("outcome.exited")
    assert host.get("outcome.exited_time") == 0.0
    assert 0.0 < host.get("outcome.first_contact_time") < host.get("outcome.arrested_time")


def test_step_mode_never_returns_early():
    for values, outcome, steps in CASES:
        _, _event, outputs = expected(values, outcome, steps)
        host = Host(3, values)
        for k in range(steps):
            assert host.step(k * H, H) == OK
            assert host.last[:3] == (False, False, False)
        assert host.outputs() == outputs


def test_stop_on_event():
    host = Host(2, {**SMALL, "stop_on_event": True})
    for k in range(200):
        status = host.step(k * H, H)
        if status != OK:
            break
    assert status == DISCARD
    assert host.fmu.getBooleanStatus(fmi2Terminated)
    times = [host.get(f"outcome.{name}_time") for name in ("arrested", "detached", "exited", "passed")]
    assert abs(host.fmu.getRealStatus(fmi2LastSuccessfulTime) - max(times)) <= 1e-12
    host = Host(3, {**SMALL, "stop_on_event": True})
    for k in range(200):
        assert host.step(k * H, H) == OK
        if host.last[1]:
            break
    assert host.last[1]


def test_stop_on_event_shows_the_outcome_in_the_step_that_ends():
    """Masters with event mode (FMPy, fmusim) write a row when a step asks to end, and call nothing more: it must have the
    outcome."""
    for values, _, steps in CASES:
        for early in (False, True):
            host, t = Host(3, {**values, "stop_on_event": True}, events=True, early=early), 0.0
            while t < steps * H:
                assert host.step(t, H) == OK
                event, ended, _, t = host.last
                row = {name: host.get(f"{name}_time") for name in ENDING if host.get(name)}
                if ended:
                    break
                assert row == {}
                if event:
                    host.fmu.enterEventMode()
                    assert not host.fmu.updateDiscreteStates()[1]
                    host.fmu.enterStepMode()
            assert ended and event
            assert len(row) == 1
            assert t - (TICK if early else H) < max(row.values()) <= t + TICK, (row, t)
            # A master that handles the event first is asked there.
            host.fmu.enterEventMode()
            assert host.fmu.updateDiscreteStates()[1]


def test_stop_on_event_in_fmpy():
    outputs = [*ENDING, *(f"{name}_time" for name in ENDING)]
    for version in (2, 3):
        values = dict(Host(version).whole(SMALL).items())
        for early in [False, True] if version == 3 else [False]:
            rows = fmpy.simulate_fmu(
                str(ARCHIVES[version]),
                fmi_type="CoSimulation",
                start_values={**values, "stop_on_event": True},
                output=outputs,
                stop_time=2e-4,
                output_interval=H,
                use_event_mode=version == 3,
                early_return_allowed=early,
            )
            before, last = ({name: float(row[f"{name}_time"]) for name in ENDING if row[name]} for row in rows[-2:])
            print(
                f"\nFMI {version}, early return {early}: last row of FMPy at {float(rows[-1]['time'])!r} s {last}",
                end=" ",
                flush=True,
            )
            assert (before, len(last)) == ({}, 1)
            assert abs(max(last.values()) - rows[-1]["time"]) < H


def test_events_are_logged_on_request():
    host = Host(3, SMALL, logging_on=True).run(0, 5, H)
    assert host.said("first contact at 8e-8 s, internal step 4"), host.log
    host = Host(3, SMALL, logging_on=False)
    host.fmu.setDebugLogging(True, ["logEvents"])
    host.run(0, 5, H)
    assert {category for _, category, _ in host.log} == {"logEvents"}
    host = Host(3, SMALL, logging_on=False).run(0, 5, H)
    assert host.log == []
