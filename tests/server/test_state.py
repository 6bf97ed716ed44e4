"""The state machine, driven at random: what it promises holds whatever happens in whatever order."""

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from tilecast.jobs import state
from tilecast.jobs.state import ACTIVE, FINAL, TRIES, Command, State, Status, transition

EVENTS = [
    state.Started(),
    state.Paused(),
    state.Resumed(),
    state.Cancelled(),
    state.Finished(),
    state.Failed("objects.a", "is wrong"),
    state.Crashed(alone=True),
    state.Crashed(alone=False),
    state.Cleared(),
    state.Recovered(),
]


class Life(RuleBasedStateMachine):
    """One job, with a shell that does what it is commanded."""

    def __init__(self):
        super().__init__()
        self.status = Status()
        self.dispatched = True
        self.called_back = 0
        self.ends = 0

    @rule(event=st.sampled_from(EVENTS))
    def happens(self, event):
        before = self.status
        try:
            self.status, commands = transition(before, event)
        except state.Refused as refusal:
            assert str(refusal)
            assert self.status == before
            return
        if isinstance(event, state.Recovered):
            self.dispatched = False  # the process that had it is gone
        for command in commands:
            self.do(command)
        if before.state.final:
            assert self.status == before, "nothing but a retry leaves a final state"
        self.ends += self.status.state.final and not before.state.final

    @rule()
    def retried(self):
        before = self.status
        try:
            self.status, commands = transition(before, state.Retried())
        except state.Refused:
            assert before.state not in (State.FAILED, State.CANCELLED)
            return
        assert before.state in (State.FAILED, State.CANCELLED)
        assert self.status == Status(State.QUEUED)
        for command in commands:
            self.do(command)
        self.ends = 0
        self.called_back = 0

    def do(self, command):
        match command:
            case Command.ENQUEUE:
                assert not self.dispatched, "enqueued twice"
                self.dispatched = True
            case Command.WITHDRAW | Command.CLEAN:
                self.dispatched = False
            case Command.CALL_BACK:
                self.called_back += 1

    @invariant()
    def the_dispatcher_has_exactly_what_is_to_be_rendered(self):
        assert self.dispatched == (self.status.state in (State.QUEUED, State.RUNNING))

    @invariant()
    def it_ends_once_and_tells_once(self):
        assert self.ends == self.status.state.final
        assert self.called_back == self.ends

    @invariant()
    def only_a_failed_job_has_an_error(self):
        assert (self.status.error_message is not None) == (self.status.state is State.FAILED)

    @invariant()
    def crashes_stay_below_the_limit_unless_it_failed(self):
        assert self.status.crashes < TRIES or self.status.state is State.FAILED


TestLife = Life.TestCase
TestLife.settings = settings(max_examples=200, stateful_step_count=30, deadline=None)


def after(*events) -> Status:
    status = Status()
    for event in events:
        status, _ = transition(status, event)
    return status


def test_states_are_final_or_active():
    assert FINAL == {State.DONE, State.FAILED, State.CANCELLED}
    assert ACTIVE == {State.QUEUED, State.RUNNING, State.PAUSED}


def test_a_poison_job_fails_at_the_third_death():
    suspect = after(state.Started(), state.Crashed(alone=False), state.Crashed(alone=True))
    assert suspect.state is State.RUNNING
    dead, commands = transition(suspect, state.Crashed(alone=True))
    assert dead.state is State.FAILED
    assert "died 3 times" in dead.error_message
    assert Command.WITHDRAW in commands


def test_deaths_in_company_prove_nothing():
    status = after(state.Started(), *[state.Crashed(alone=False)] * 10)
    assert (status.state, status.crashes) == (State.RUNNING, 1)


def test_a_job_that_was_cleared_has_all_its_tries_again():
    status = after(state.Started(), state.Crashed(alone=False), state.Crashed(alone=True), state.Cleared())
    assert status.crashes == 0


@pytest.mark.parametrize("final", [state.Finished(), state.Failed("", "x"), state.Cancelled()])
@pytest.mark.parametrize("late", [state.Finished(), state.Failed("", "y"), state.Cancelled(), state.Paused()])
def test_what_comes_after_the_end_is_refused(final, late):
    ended = after(state.Started(), final)
    with pytest.raises(state.Refused):
        transition(ended, late)
