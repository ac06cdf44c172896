export {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, DynamicDrawUsage, Float32BufferAttribute,
  Group, LineBasicMaterial, LineSegments, MathUtils, Mesh, MeshBasicMaterial, MeshLambertMaterial, OrthographicCamera,
  PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, SRGBColorSpace, Vector2, Vector3, WebGLRenderer,
} from "three";
