% The grid of micro-images that the Light Field Toolbox finds in a white image of a hexagonal array, for
% `holo eval-calibration WHITE.grid.json --truth DIR`.
%
%     apt-get install octave octave-image
%     octave-cli lftoolbox_grid.m TOOLBOX_FOLDER WHITE.png PITCH_PX WHITE.grid.json
%
% PITCH_PX is the distance of micro-images by the data sheet, which LFUtilProcessWhiteImages takes from the camera's own file; its
% other options are the defaults of that program. What Octave lacks is below: two functions of MATLAB, discs
% of any radius, and images that are real after two transforms.
1;

function image = ifft2(transformed)
  image = real(builtin('ifft2', transformed));
end

function h = fspecial(~, radius)
  % The share of every pixel that a disc covers.
  n = ceil(radius - 0.5);
  fine = ((0:15) + 0.5) / 16 - 0.5;
  x = reshape((-n:n) + fine', 1, []);
  h = squeeze(sum(sum(reshape(x.^2 + (x').^2 <= radius^2, 16, 2*n + 1, 16, 2*n + 1), 1), 3));
  h = h / sum(h(:));
end

function points = DelaunayTri(y, x)
  points = [y, x];
end

function labels = nearestNeighbor(points, y, x)
  labels = dsearchn(points, [y(:), x(:)]);
end

pkg load image
[toolbox, white, pitch, out] = argv(){:};
addpath(toolbox, [toolbox '/SupportFunctions']);
options = struct('Orientation', 'horz', 'FilterDiskRadiusMult', 1/3, 'CropAmt', 25, 'SkipStep', 250, ...
                 'ApproxLensletSpacing', str2double(pitch), 'Precision', 'single');
image = single(imread(white));
model = LFBuildLensletGridModel(image ./ max(image(:)), options);
file = fopen(out, 'w');
fprintf(file, '{"LensletGridModel": {"Orientation": "horz"');
for key = {'HSpacing', 'VSpacing', 'HOffset', 'VOffset', 'Rot', 'UMax', 'VMax', 'FirstPosShiftRow'}
  fprintf(file, ', "%s": %.17g', key{1}, model.(key{1}));
end
fprintf(file, '}}\n');
fclose(file);
