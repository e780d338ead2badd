"""Soft spheres and tracers from a table."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecume.errors import SceneError
from ecume.scenes.load import load_scene

SOFT = """\
model = "soft"
duration = 1
frame_every = 1
{source}
liquid.viscosity = 1
cell.size = ["1 cm", "1 cm"]
{particles}
"""
TRACERS = """\
model = "tracers"
duration = 1
frame_every = 1
{source}
liquid.viscosity = 1
tank.high = {high}
{particles}
"""
FLAT, DEEP = "[0.01, 0.01]", "[0.01, 0.01, 0.01]"
MODULUS, DENSITY = "modulus = 1e4", "density = 1100"


def species(*tables):
    return "\n".join(f"[[particles]]\n{table}" for table in tables)


def read(folder, text, table, particles, **more):
    (folder / "beads.csv").write_text(table)
    (folder / "scene.toml").write_text(text.format(source='particles_from = "beads.csv"', particles=particles, **more))
    return load_scene(folder / "scene.toml")


def fault(folder, text, table, particles, **more):
    with pytest.raises(SceneError) as caught:
        read(folder, text, table, particles, **more)
    return "\n".join(map(str, caught.value.faults))


def test_soft_spheres_have_the_places_radii_and_species_of_their_table(tmp_path):
    table = "name,x [mm],y [mm],diameter [mm]\nb,1,2,1\na,3,4,2\na,5,6,3\n"
    scene = read(tmp_path, SOFT, table, species(f'name = "a"\n{MODULUS}', f'name = "b"\n{MODULUS}\nradius = 7e-4'))
    one, two = scene.particles
    assert one.positions == ((3e-3, 4e-3), (5e-3, 6e-3))
    assert one.radii == (1e-3, 1.5e-3)
    assert (two.positions, two.radius) == (((1e-3, 2e-3),), 7e-4)  # what a species states takes precedence


@pytest.mark.parametrize(("high", "z", "places"), [(FLAT, "", 2), (DEEP, ",z [mm]", 3)])
def test_tracers_have_the_places_and_velocities_of_their_table(tmp_path, high, z, places):
    table = f"x [mm],y [mm],vx [mm/s]{z}\n1,2,3{',4' * bool(z)}\n"
    (one,) = read(tmp_path, TRACERS, table, species(f"{DENSITY}\nradius = 1e-6"), high=high).particles
    assert one.positions == ((1e-3, 2e-3, 4e-3)[:places],)
    assert one.velocities == ((3e-3, 0.0, 0.0)[:places],)


def test_the_velocity_that_a_species_states_takes_precedence_as_its_radius_does(tmp_path):
    particles = species(f"{DENSITY}\nradius = 1e-6\nvelocity = [0.5, 0.0]")
    (one,) = read(tmp_path, TRACERS, "x,y,vx,radius\n1e-3,2e-3,3,9\n", particles, high=FLAT).particles
    assert (one.velocity, one.velocities, one.radius) == ((0.5, 0.0), (), 1e-6)


NUMBER = st.floats(1e-3, 9e-3)


@given(places=st.lists(st.tuples(NUMBER, NUMBER), min_size=1, max_size=5))
def test_a_table_means_the_same_scene_as_its_positions(tmp_path_factory, places):
    folder = tmp_path_factory.mktemp("table")
    lines = "".join(f"{x!r},{y!r}\n" for x, y in places)
    keys = f"{DENSITY}\nradius = 1e-6"
    scene = read(folder, TRACERS, f"x,y\n{lines}", species(keys), high=FLAT)
    given = f"{keys}\npositions = {[list(place) for place in places]}"
    assert scene == load_scene(TRACERS.format(source="", particles=species(given), high=FLAT))


@pytest.mark.parametrize(
    ("text", "table", "particles", "expected"),
    [
        (SOFT, "x,y,vx\n1,2,3\n", species(MODULUS), "beads.csv, line 1, column 'vx': no such column"),
        (SOFT, "x,y\n1e-3,2e-3\n", species(MODULUS), "radius: is missing"),
        (SOFT, "x,y,radius\n1e-3,2e-3,1\n", species(f"{MODULUS}\ncount = 2"), "count: has no meaning beside"),
        (SOFT, "x,y\n1e-3,2e-3\n", species(f'{MODULUS}\nradius = 1e-6\ndensity = ["a"]'), "density: got ['a']"),
        (TRACERS, "x,y\n1,2\n", species(f"{DENSITY}\nradius = 1e-6"), "has no column z"),
        (TRACERS, "x,y,z\n1,2,1\n", species("radius = 1e-6\ndensity = [9, 9]"), "density: got [9, 9]"),
        (TRACERS, "x,y,z\n1,2,x\n", species(f"{DENSITY}\nradius = 1e-6"), "line 2, column z: got 'x'"),
        (TRACERS, "x,y,z\n1,2,1\n", species('name = "a"', 'name = "b"'), "has particles without a name"),
        (TRACERS, "x,y,z\n1,2,1\n", "", "the scene has no [[particles]]; expected one [[particles]] table"),
        (TRACERS, "x,y,z,name\n1,2,1,c\n", species('name = "a"', 'name = "b"'), "expected a species named 'c'"),
        (TRACERS, "x,y,z\n1,2,1\n", 'start_from = "a@0"', "only one can stand"),
    ],
)
def test_what_a_table_lacks_is_said_at_its_key(tmp_path, text, table, particles, expected):
    assert expected in fault(tmp_path, text, table, particles, high=DEEP)


def test_the_liquid_of_a_tank_is_not_read_at_the_top_of_its_scene(tmp_path):
    text = (
        'model = "sph"\nduration = 1\nframe_every = 1\nspacing = 0.01\nparticles_from = "a.csv"\ntank.high = [1, 1]\n'
    )
    with pytest.raises(SceneError, match="particles_from: no such key"):
        load_scene(text)
