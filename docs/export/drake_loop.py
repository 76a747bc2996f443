"""A computed-torque loop in Drake around `arm.py`, which gd-analyze exported; run with Drake 1.51."""

import arm  # what gd-analyze exported
import numpy as np
from pydrake.all import DiagramBuilder, LeafSystem, MultibodyPlant, Parser, Simulator


class ComputedTorque(LeafSystem):
    """The torque that makes every joint follow 0.3 sin 2t."""

    def __init__(self, n):
        super().__init__()
        self.DeclareVectorInputPort("state", 2 * n)
        self.DeclareVectorOutputPort("torque", n, self.torque)

    def torque(self, context, output):
        """Torque at the state of the arm."""
        q, qd = np.split(self.get_input_port().Eval(context), 2)
        wanted, speed = 0.3 * np.sin(2.0 * context.get_time()), 0.6 * np.cos(2.0 * context.get_time())
        output.SetFromVector(arm.torque(q, qd, -4.0 * wanted + 40.0 * (speed - qd) + 400.0 * (wanted - q)))


builder = DiagramBuilder()
plant = builder.AddSystem(MultibodyPlant(1e-3))
Parser(plant).AddModels("my_robot.urdf")
plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base_link"))
for name in arm.JOINTS:  # a URDF without <transmission> has no actuators
    plant.AddJointActuator(name, plant.GetJointByName(name))
plant.Finalize()
law = builder.AddSystem(ComputedTorque(len(arm.JOINTS)))
builder.Connect(plant.get_state_output_port(), law.get_input_port())
builder.Connect(law.get_output_port(), plant.get_actuation_input_port())
simulator = Simulator(builder.Build())
plant.SetVelocities(plant.GetMyMutableContextFromRoot(simulator.get_mutable_context()), 0.6 * np.ones(3))
simulator.AdvanceTo(2.0)
