"""Control of the exact arm by controllers that know more or less of it, and how well they track a motion."""

from gd_analyze.closed_loop.bounds import CertifiedTracking as CertifiedTracking
from gd_analyze.closed_loop.control import control as control
from gd_analyze.closed_loop.controllers import CONTROLLERS as CONTROLLERS
from gd_analyze.closed_loop.controllers import Controller as Controller
from gd_analyze.closed_loop.gains import Gains as Gains
from gd_analyze.closed_loop.settings import CONTINUOUS as CONTINUOUS
from gd_analyze.closed_loop.settings import ControlSettings as ControlSettings
from gd_analyze.closed_loop.study import ControlStudy as ControlStudy
from gd_analyze.closed_loop.study import TrackedLoop as TrackedLoop
from gd_analyze.closed_loop.tolerance import Tolerance as Tolerance
