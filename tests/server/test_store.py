"""The store, on SQLite and on a real PostgreSQL: the same promises on both."""

import threading

import pytest
from sqlalchemy import create_engine, text

from tilecast.jobs.faults import CannotStart, InUse, KeyReused, TooMany
from tilecast.jobs.records import NewJob, TileRow
from tilecast.jobs.state import State, Status
from tilecast.jobs.store import Store

@pytest.fixture(params=["sqlite", "postgresql"])
def url(request, tmp_path):
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'test.db'}"
    return request.getfixturevalue("postgres_url")


@pytest.fixture
def store(url):
    store = Store(url)
    yield store
    store.close()


def new(name: str, owner: str = "me", key: str | None = None, request: str = "r", scene: str = "s") -> NewJob:
    stop, facts = {"seconds": None}, {"kernel": "k"}
    return NewJob(name, owner, f"the {name}", 0, scene, 64, 48, 16, 16, stop, False, facts, None, key, request)


def add(store: Store, name: str, **fields):
    job, created = store.create(new(name, **fields), 1000, {"state": "queued"})
    assert created
    return job


def test_a_job_comes_back_as_it_went_in(store):
    job = add(store, "a")
    assert store.get("a") == job
    assert (job.state, job.name, job.stop, job.facts) == (State.QUEUED, "the a", {"seconds": None}, {"kernel": "k"})
    assert store.get("b") is None


def test_jobs_outlive_the_store(url):
    first = Store(url)
    job = add(first, "a")
    first.close()
    second = Store(url)
    assert second.get("a") == job
    second.close()


def test_the_same_key_and_request_name_the_same_job(store):
    job = add(store, "a", key="k")
    assert store.create(new("b", key="k"), 1000, {}) == (job, False)
    assert store.by_idempotency_key("me", "k", "r") == job
    assert store.get("b") is None


def test_a_key_with_another_request_is_refused(store):
    add(store, "a", key="k")
    with pytest.raises(KeyReused):
        store.create(new("b", key="k", request="other"), 1000, {})


def test_keys_belong_to_their_owners(store):
    add(store, "a", key="k", owner="me")
    add(store, "b", key="k", owner="you")


def test_many_jobs_need_no_key(store):
    add(store, "a")
    add(store, "b")


def test_an_owner_may_have_only_so_many_jobs(store):
    store.create(new("a"), 2, {})
    store.create(new("b"), 2, {})
    with pytest.raises(TooMany) as refused:
        store.create(new("c"), 2, {})
    assert refused.value.retry_after > 0
    store.create(new("d", owner="you"), 2, {})
    job = store.get("a")
    store.change(job, Status(State.CANCELLED), {})
    store.create(new("c"), 2, {})


def test_submissions_at_the_same_time_make_one_job_for_each_key(store):
    results = []

    def submit(number: int) -> None:
        for key in range(5):
            results.append(store.create(new(f"{number}-{key}", key=f"k{key}"), 1000, {}))

    threads = [threading.Thread(target=submit, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 40
    assert sum(created for _, created in results) == 5
    assert len({job.id for job, _ in results}) == 5


def test_pages_cover_everything_once_newest_first(store):
    names = [f"job{number:02}" for number in range(25)]
    for name in names:
        add(store, name)
    seen, before = [], None
    while True:
        page, before = store.page(None, 10, before)
        seen += [job.id for job in page]
        if before is None:
            break
    assert seen == names[::-1]


def test_pages_can_be_of_one_state(store):
    for name in "abc":
        add(store, name)
    store.change(store.get("b"), Status(State.RUNNING), {})
    assert [job.id for job in store.page(State.RUNNING, 10, None)[0]] == ["b"]
    assert [job.id for job in store.page(State.QUEUED, 10, None)[0]] == ["c", "a"]
    assert store.counts() == {**dict.fromkeys(State, 0), State.QUEUED: 2, State.RUNNING: 1}


def test_a_change_needs_the_state_that_it_was_decided_on(store):
    job = add(store, "a")
    changed = store.change(job, Status(State.RUNNING), {"state": "running"}, started=1.5)
    assert (changed.state, changed.started, changed.event) == (State.RUNNING, 1.5, 2)
    assert store.change(job, Status(State.CANCELLED), {"state": "cancelled"}) is None
    assert store.get("a").state is State.RUNNING


def test_a_database_of_an_earlier_version_gets_the_columns_that_it_lacks(url):
    store = Store(url)
    add(store, "a")
    store.close()
    engine = create_engine(url)
    with engine.begin() as connection:
        connection.execute(text("ALTER TABLE tiles DROP COLUMN relative_mse"))
        connection.execute(text("INSERT INTO tiles (job, index, version, samples, event) VALUES ('a', 0, 1, 2, 5)"
                                .replace("index", '"index"')))
    engine.dispose()
    store = Store(url)
    store.save_progress("a", [TileRow(1, 1, 2, relative_mse=0.5)], [])
    assert [tile.relative_mse for tile in store.tiles("a")] == [None, 0.5]
    store.close()


def told(store: Store, job: str, event: int) -> list[tuple]:
    return [(entry.event, entry.type, entry.data) for entry in store.since(job, event)]


def test_listeners_hear_what_they_missed_in_order(store):
    job = add(store, "a")
    store.save_progress("a", [TileRow(0, 1, 2), TileRow(1, 1, 2)], [])
    store.save_progress("a", [TileRow(0, 2, 4, relative_mse=0.25)], [{"samples": 2}], progress=0.5)
    store.change(job, Status(State.PAUSED), {"state": "paused"})
    assert told(store, "a", 0) == [
        (1, "state", {"state": "queued"}),
        (3, "tile", {"index": 1, "version": 1, "samples": 2, "relative_mse": None}),
        (4, "error", {"samples": 2}),
        (5, "tile", {"index": 0, "version": 2, "samples": 4, "relative_mse": 0.25}),
        (6, "state", {"state": "paused"}),
    ]
    assert [number for number, _, _ in told(store, "a", 4)] == [5, 6]
    assert told(store, "a", 6) == []
    assert store.since("nobody", 0) is None
    assert store.get("a").event == 6


def test_long_histories_are_told_in_parts(store):
    add(store, "a")
    store.save_progress("a", [TileRow(index, 1, 2) for index in range(50)], [])
    seen = 0
    while entries := store.since("a", seen, limit=7):
        assert len(entries) <= 7
        assert [entry.event for entry in entries] == list(range(seen + 1, seen + 1 + len(entries)))
        seen = entries[-1].event
    assert seen == 51


def test_what_is_kept_does_not_grow_with_time(store):
    job = add(store, "a")
    for version in range(1, 101):
        store.save_progress("a", [TileRow(index, version, version) for index in range(4)], [])
        job = store.change(job, Status(State.PAUSED if version % 2 else State.QUEUED), {"n": version})
    entries = store.since("a", 0)
    assert len(entries) <= 4 + 32
    assert [entry.data for entry in entries if entry.type == "state"][-1] == {"n": 100}
    assert all(entry.data["version"] == 100 for entry in entries if entry.type == "tile")


def test_saving_tells_which_versions_it_replaced(store):
    add(store, "a")
    assert store.save_progress("a", [TileRow(0, 1, 2), TileRow(1, 3, 8)], []) == [0, 0]
    assert store.save_progress("a", [TileRow(1, 4, 16), TileRow(2, 1, 2), TileRow(0, 2, 4)], []) == [3, 0, 1]
    assert [(tile.index, tile.version, tile.samples) for tile in store.tiles("a")] == [(0, 2, 4), (1, 4, 16), (2, 1, 2)]
    assert store.tile_version("a", 1) == 4
    assert store.tile_version("a", 9) == 0
    assert store.save_progress("nobody", [TileRow(0, 1, 2)], []) is None


def test_tiles_that_cannot_be_read_are_forgotten_with_the_points_that_knew_them(store):
    add(store, "a")
    store.save_progress("a", [TileRow(0, 2, 4), TileRow(1, 2, 4)], [{"samples": 2}, {"samples": 4}])
    store.forget_tiles("a", [1], points_kept=1)
    assert [tile.index for tile in store.tiles("a")] == [0]
    assert store.curve("a") == [{"samples": 2}]


def test_a_deleted_job_leaves_nothing(store):
    add(store, "a")
    add(store, "b", scene="t")
    store.save_progress("a", [TileRow(0, 1, 2)], [{"samples": 2}])
    assert store.needs_scene("s")
    assert store.delete("a")
    assert not store.delete("a")
    assert store.get("a") is None and store.tiles("a") == [] and store.curve("a") == []
    assert not store.needs_scene("s")
    assert store.scenes() == {"t"}


def test_a_second_server_is_refused_by_postgresql(postgres_url):
    first = Store(postgres_url)
    with pytest.raises(InUse):
        Store(postgres_url)
    first.close()
    Store(postgres_url).close()


@pytest.mark.parametrize(
    "url",
    [
        "nonsense",
        "sqlite:////nowhere/at/all.db",
        "postgresql+psycopg://somebody:secret@127.0.0.1:1/nothing",
        "nosuchdatabase://somebody:secret@127.0.0.1/nothing",
    ],
)
def test_a_database_that_cannot_be_opened_is_told_without_its_password(url):
    with pytest.raises(CannotStart) as refused:
        Store(url)
    assert "cannot open the database" in str(refused.value)
    assert "secret" not in str(refused.value) and "\n" not in str(refused.value)
